"""What a session tells whoever records it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from calibration.record import CalibrationRecord
from cell.devices.camera import Frame


@dataclass(frozen=True, slots=True)
class SentView:
    """A view that is part of a reply: the frame and how it was encoded."""

    frame: Frame
    mime: str


@dataclass(frozen=True, slots=True)
class Reply:
    """Everything that answers one command, to be sent in one write.

    Attributes:
        text: The reply's lines, each ended by LF.
        data: Binary data that follows the text at once; shared, never changed.
        view: The view that `data` encodes, if it is one.
        closes: Whether the server closes the connection afterwards.
    """

    text: bytes
    data: bytes | memoryview = b""
    view: SentView | None = None
    closes: bool = False


class Journal(Protocol):
    """Takes note of one session, from its first byte to its end.

    Called by the session's thread only, in the order things happen. Line and reply
    are on disk when the reply leaves, so that a killed server has recorded every
    complete step; what happened in the cell meanwhile may follow when it has left.
    """

    def received(self, line: bytes) -> None:
        """A line arrived (without its LF)."""

    def replied(self, reply: Reply) -> None:
        """A reply is about to leave."""

    def settled(self) -> None:
        """The reply has left; what could wait until now is written."""

    def close(self, reason: str) -> None:
        """The session is over; flush everything and finish the recording."""


class NoJournal:
    """Takes no note of anything."""

    def received(self, line: bytes) -> None:
        """Do nothing."""

    def replied(self, reply: Reply) -> None:
        """Do nothing."""

    def settled(self) -> None:
        """Do nothing."""

    def close(self, reason: str) -> None:
        """Do nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionStart:
    """What a replay needs to begin where the recorded session began.

    Attributes:
        session_id: Name of the session, unique on this machine.
        script_name: File name of the script.
        script_text: Its text.
        profile_text: TOML text of the profile, without what was calibrated.
        dialect: MAS dialect of the listener.
        seed: Seed of the session (before any `USE_GLOBAL_SEED`).
        world_json: The twin's world as the session found it, empty on hardware.
        peer: Address of the client.
        versions: Version of everything that matters, by name.
        calibrations: The calibrations in force, which the cell knew besides its profile.
        backlog: Lines and replies of this connection before it took the cell.
    """

    session_id: str
    script_name: str
    script_text: str
    profile_text: str
    dialect: str
    seed: int
    world_json: str
    peer: str
    versions: dict[str, str]
    calibrations: tuple[CalibrationRecord, ...] = ()
    backlog: Sequence[tuple[bytes, Reply]] = ()
