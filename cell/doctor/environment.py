"""What lies around a cell: folders, disk, clocks, ports. Everything the checks ask of it."""

from __future__ import annotations

import os
import shutil
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Protocol


@dataclass(frozen=True, slots=True)
class PortState:
    """Whether the server could listen at its address, and what was seen."""

    is_free: bool
    seen: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PageState:
    """The page that shows pictures on the television, as it tells of itself.

    Attributes:
        is_connected: Whether a browser has it open.
        width_px: Width of what the page covers.
        height_px: Height of what the page covers.
        trouble: Why it does not show what it should; empty when it does.
        is_served: Whether a program serves it now.
    """

    is_connected: bool
    width_px: int = 0
    height_px: int = 0
    trouble: str = ""
    is_served: bool = True


class Environment(Protocol):
    """What the checks ask of the computer."""

    @property
    def state_folder(self) -> Path | None:
        """Where ledger, world and lock are kept; None where they are kept in memory."""

    @property
    def recordings_folder(self) -> Path | None:
        """Where recordings go; None where nothing is recorded."""

    def now(self) -> datetime:
        """Return date and time of the wall clock, with its time zone."""

    def steady_s(self) -> float:
        """Return seconds of a clock that nobody sets."""

    def free_bytes(self, folder: Path) -> int:
        """Return how much space is left where a folder lies."""

    def holder_of(self, port: str) -> str:
        """Return which process has a serial port open, empty where nobody knows."""

    def server_port(self, host: str, port: int) -> PortState:
        """Return whether the server could listen at an address."""

    def page(self) -> PageState | None:
        """Return the picture page's state, None where there is no page."""

    def check_world(self) -> str:
        """Return what is wrong with the kept world, empty when nothing is or there is none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemEnvironment:
    """The computer that the program runs on.

    Attributes:
        state_folder: Where ledger, world and lock are kept; None for in memory.
        recordings_folder: Where recordings go; None for none.
        page_state: Asks the picture page; None where there is no page.
        world_check: Reads the kept world; None where there is none.
    """

    state_folder: Path | None = None
    recordings_folder: Path | None = None
    page_state: Callable[[], PageState] | None = None
    world_check: Callable[[], str] | None = None

    def now(self) -> datetime:
        """Return date and time of the wall clock, in UTC."""
        return datetime.now(UTC)

    def steady_s(self) -> float:
        """Return seconds of a clock that nobody sets."""
        return time.monotonic()

    def free_bytes(self, folder: Path) -> int:
        """Return how much space is left where a folder lies or will lie."""
        return shutil.disk_usage(nearest_existing(folder)).free

    def holder_of(self, port: str) -> str:
        """Return which process has a serial port open, empty where nobody knows."""
        return holder_of(port)

    def server_port(self, host: str, port: int) -> PortState:
        """Bind an address for a moment and say what came of it."""
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        with socket.socket(family, socket.SOCK_STREAM) as listener:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                listener.bind((host, port))
            except OSError as error:
                return PortState(is_free=False, seen=error.strerror or str(error))
        return PortState(is_free=True)

    def page(self) -> PageState | None:
        """Ask the picture page."""
        return None if self.page_state is None else self.page_state()

    def check_world(self) -> str:
        """Read the kept world."""
        return "" if self.world_check is None else self.world_check()


def holder_of(device: str) -> str:
    """Return which process has a device file open, as far as the system tells."""
    try:
        wanted = os.path.realpath(device)
        for process in Path("/proc").iterdir():
            if process.name.isdigit() and _has_open(process, wanted):
                name = (process / "comm").read_text("utf-8", "replace").strip()
                return f"process {process.name} ({name})"
    except OSError:
        return ""
    return ""


def nearest_existing(folder: Path) -> Path:
    """Return a folder, or the first one above it that exists."""
    for candidate in (folder, *folder.parents):
        if candidate.exists():
            return candidate
    return Path(folder.anchor or ".")


def _has_open(process: Path, wanted: str) -> bool:
    try:
        return any(os.readlink(file) == wanted for file in (process / "fd").iterdir())
    except OSError:
        return False  # Another user's process, or one that has just ended.
