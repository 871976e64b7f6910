"""The scripts that come with the language."""

from __future__ import annotations

from importlib import resources

from dsl.errors import UnknownName


def library_script(name: str) -> str:
    """Return the text of a shipped script.

    Args:
        name: Such as `mash`.

    Raises:
        UnknownName: There is no such script.
    """
    if name in library_names():
        return (resources.files(__name__) / f"{name}.cell").read_text("utf-8")
    raise UnknownName("shipped script", name, library_names())


def library_names() -> list[str]:
    """Return the names of the shipped scripts."""
    files = resources.files(__name__).iterdir()
    return sorted(f.name.removesuffix(".cell") for f in files if f.name.endswith(".cell"))
