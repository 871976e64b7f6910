"""Names of sessions: sortable by time, unique on a machine."""

from __future__ import annotations

import secrets
from datetime import UTC, datetime


def new_session_id(now: datetime | None = None) -> str:
    """Return a name such as `20260102T030405-9f2c1a`: UTC time and a random part.

    The random part only keeps two sessions of one second apart; nothing that a
    session does depends on it.
    """
    moment = datetime.now(UTC) if now is None else now.astimezone(UTC)
    return f"{moment:%Y%m%dT%H%M%S}-{secrets.token_hex(3)}"
