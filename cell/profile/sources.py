"""Where profiles come from: shipped ones and a user's own by name, any by path."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import platformdirs

from cell.errors import ProfileError


@dataclass(frozen=True, slots=True)
class ProfileSource:
    """A profile's text and where it comes from.

    Attributes:
        name: How messages call it: the path of a file, `mash.toml` for a shipped one.
        text: The TOML text, with line feeds only.
        path: The file; None for a shipped one.
    """

    name: str
    text: str
    path: Path | None = None


def find_profile(name_or_path: str) -> ProfileSource:
    """Return a shipped or a user's profile by name, any by path.

    Raises:
        ProfileError: There is no such profile, or it cannot be read.
    """
    try:
        if is_path(name_or_path):
            path = Path(name_or_path)
            return ProfileSource(name_or_path, _text(path), path)
        if name_or_path in shipped_profiles():
            shipped = resources.files("cell") / "profiles" / f"{name_or_path}.toml"
            return ProfileSource(
                f"{name_or_path}.toml", with_line_feeds(shipped.read_text("utf-8"))
            )
        path = user_profiles_folder() / f"{name_or_path}.toml"
        if path.is_file():
            return ProfileSource(str(path), _text(path), path)
    except FileNotFoundError as error:
        raise ProfileError(f"there is no file {name_or_path}") from error
    except OSError as error:
        raise ProfileError(
            f"the profile {name_or_path} cannot be read: {error.strerror or error}"
        ) from error
    except UnicodeDecodeError as error:
        raise ProfileError(
            f"the profile {name_or_path} is not UTF-8 text (byte {error.start})"
        ) from error
    except ValueError as error:
        raise ProfileError(f"{name_or_path!r} is no name of a file: {error}") from error
    own = ", ".join(user_profiles()) or "none"
    raise ProfileError(
        f"there is no profile {name_or_path!r}; shipped are {', '.join(shipped_profiles())}, "
        f"your own in {user_profiles_folder()} {own}; a path must end in .toml"
    )


def _text(path: Path) -> str:
    """Return what is in a file; a pipe or a device has no end to be waited for.

    Raises:
        ProfileError: It is there, and no ordinary file.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise ProfileError(
            f"the profile {path} cannot be read: it is a pipe or a device; give an ordinary file"
        )
    return with_line_feeds(path.read_text("utf-8"))


def is_path(name_or_path: str) -> bool:
    """Return whether a text names a file rather than a profile."""
    return name_or_path.endswith(".toml") or "/" in name_or_path or "\\" in name_or_path


def shipped_profiles() -> list[str]:
    """Return the names of the shipped profiles."""
    folder = resources.files("cell") / "profiles"
    return sorted(
        f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml")
    )


def user_profiles_folder() -> Path:
    """Return where a user's own profiles are found by name; `XDG_CONFIG_HOME` moves it."""
    return platformdirs.user_config_path("robocell") / "profiles"


def user_profiles() -> list[str]:
    """Return the names of the user's own profiles that no shipped one has."""
    found = {path.stem for path in user_profiles_folder().glob("*.toml")}
    return sorted(found - set(shipped_profiles()))


def with_line_feeds(text: str) -> str:
    """Return a text with line feeds only, as TOML reads it, and without a byte order mark."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n")


def profile_text(name_or_path: str) -> str:
    """Return the TOML text of a profile.

    Raises:
        ProfileError: There is no such profile, or it cannot be read.
    """
    return find_profile(name_or_path).text
