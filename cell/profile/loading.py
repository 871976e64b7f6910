"""From a profile's TOML text to the profile, or to an error that names every wrong field."""

from __future__ import annotations

import tomllib
from importlib import resources
from pathlib import Path

from pydantic import ValidationError

from cell.errors import ProfileError
from cell.profile.cell import Profile


def load_profile(name_or_path: str) -> Profile:
    """Load a shipped profile by name or any profile by path.

    Raises:
        ProfileError: There is no such profile, it is not TOML, or a field is wrong.
    """
    return parse_profile(profile_text(name_or_path), name_or_path)


def profile_text(name_or_path: str) -> str:
    """Return the TOML text of a profile.

    Raises:
        ProfileError: There is no such profile, or it cannot be read.
    """
    path = Path(name_or_path)
    try:
        if path.suffix == ".toml":
            return path.read_text("utf-8")
        shipped = resources.files("cell") / "profiles" / f"{name_or_path}.toml"
        if shipped.is_file():
            return shipped.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ProfileError(f"the profile {name_or_path} cannot be read: {error}") from error
    raise ProfileError(
        f"there is no profile {name_or_path!r}; shipped are {', '.join(shipped_profiles())}, "
        "and a path must end in .toml"
    )


def shipped_profiles() -> list[str]:
    """Return the names of the shipped profiles."""
    folder = resources.files("cell") / "profiles"
    return sorted(
        f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml")
    )


def parse_profile(text: str, source: str) -> Profile:
    """Read a profile from TOML text.

    Args:
        text: The TOML text.
        source: Where it comes from, for messages.

    Raises:
        ProfileError: The text is not TOML, or a field is wrong; every wrong field is named.
    """
    try:
        return Profile.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ProfileError(f"{source} is not valid TOML: {error}") from error
    except ValidationError as error:
        problems = "; ".join(
            f"{'.'.join(str(part) for part in e['loc'])}: {e['msg']}" for e in error.errors()
        )
        raise ProfileError(f"{source}: {problems}") from error
