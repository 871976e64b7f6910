"""What to do about an SQLite file that cannot be used: is it damaged, or out of reach?

Only a damaged file may be moved away. Where the disk is full or another program is in the
way, everything that the file holds is still there.
"""

from __future__ import annotations

import sqlite3

_DAMAGED = frozenset({sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT})
_NO_ROOM = frozenset({sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR})
_IN_USE = frozenset({sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED})
_NOT_ALLOWED = frozenset(
    {
        sqlite3.SQLITE_READONLY,
        sqlite3.SQLITE_CANTOPEN,
        sqlite3.SQLITE_PERM,
        sqlite3.SQLITE_AUTH,
    }
)

_PRIMARY = 0xFF
"""The low byte of an extended result code is its primary one (sqlite.org/rescode.html)."""


def is_damaged(error: sqlite3.Error | OSError) -> bool:
    """Return whether an error says that the file's content is at fault.

    A database with other tables counts: SQLite calls that a plain error in the statement.
    """
    if isinstance(error, OSError):
        return False
    code = _code(error)
    is_foreign = code == sqlite3.SQLITE_ERROR and "no such" in str(error)
    return code in _DAMAGED or is_foreign


def advice(error: sqlite3.Error | OSError, *, if_damaged: str) -> str:
    """Return what to do about an error of a kept database.

    Args:
        error: What SQLite, or the system, said.
        if_damaged: What to do where the file's content is at fault.
    """
    if is_damaged(error):
        return if_damaged
    code = 0 if isinstance(error, OSError) else _code(error)
    if code in _NO_ROOM:
        return "free space on its disk, or look whether the disk fails; keep the file, it is intact"
    if code in _IN_USE:
        return "stop the other program that has it open; keep the file, it is intact"
    if code in _NOT_ALLOWED or isinstance(error, OSError):
        return (
            "give the file and its folder to the user who runs the cell, and look whether the "
            "disk is full or read-only; keep the file, it is intact"
        )
    return "keep the file, nothing says that it is damaged; start the program anew"


def _code(error: sqlite3.Error) -> int:
    # Errors of Python's own module, such as that of a closed database, have no code.
    code: int | None = getattr(error, "sqlite_errorcode", None)
    return 0 if code is None else code & _PRIMARY
