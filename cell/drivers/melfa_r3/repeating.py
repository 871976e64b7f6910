"""Which requests may be sent twice when a reply is lost.

Reading something or setting it to a value does no more when it is done again. What starts
a motion does: whether the arm moves already is found out first, by the driver.
"""

from __future__ import annotations

_STARTS = (
    "EXECMOV",
    "EXECMVS",
    "EXECMVR",
    "EXECMVC",
    "RSTPWR",
    "FDEL",
    "EXECHOPEN",
    "EXECHCLOSE",
    "RUN",
    "MOVSP",
    "HNDON",
    "HNDOFF",
)


def may_be_repeated(command: str, args: str = "") -> bool:
    """Return whether a request does the same when it is sent again."""
    return not (command + args).startswith(_STARTS)
