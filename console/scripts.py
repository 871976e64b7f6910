"""Finds a script by path or by the name of a shipped one, and shows what is wrong with it."""

from __future__ import annotations


def read_script(name: str) -> tuple[str, str]:
    """Return file name and text of a script.

    Args:
        name: Path of a script, or the name of a shipped one, with or without `.cell`.

    Raises:
        ConsoleError: There is no such script, or it cannot be read.
    """
    raise NotImplementedError(name)
