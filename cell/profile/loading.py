"""From a profile's TOML text to the profile, or to an error that shows every mistake."""

from __future__ import annotations

from cell.errors import ProfileError
from cell.profile.cell import CellProfile, Profile
from cell.profile.checking import check_profile
from cell.profile.sources import ProfileSource, find_profile, with_line_feeds


def load_cell_profile(name_or_path: str) -> CellProfile:
    """Load the profile of any cell: a shipped or a user's one by name, any by path.

    Raises:
        ProfileError: There is no such profile, it is not TOML, or a field is wrong.
    """
    return check_profile(find_profile(name_or_path)).require()


def load_profile(name_or_path: str) -> Profile:
    """Load the profile of a cell with a playground.

    Raises:
        ProfileError: As `load_cell_profile`, and if the cell has no playground.
    """
    return _with_playground(load_cell_profile(name_or_path), name_or_path)


def parse_cell_profile(text: str, source: str) -> CellProfile:
    """Read the profile of any cell from TOML text.

    Raises:
        ProfileError: The text is not TOML, or a field is wrong; every mistake is shown.
    """
    return check_profile(ProfileSource(source, with_line_feeds(text))).require()


def parse_profile(text: str, source: str) -> Profile:
    """Read the profile of a cell with a playground from TOML text.

    Args:
        text: The TOML text.
        source: Where it comes from, for messages.

    Raises:
        ProfileError: The text is not TOML, a field is wrong (every mistake is shown), or
            the cell has no playground.
    """
    return _with_playground(parse_cell_profile(text, source), source)


def _with_playground(profile: CellProfile, name: str) -> Profile:
    if isinstance(profile, Profile):
        return profile
    raise ProfileError(
        f"{name} is a cell without a playground (it has no [store], [heights], [blocks]): this "
        f"needs a cell such as mash"
    )
