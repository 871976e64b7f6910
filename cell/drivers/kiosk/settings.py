"""What the television's page must be told."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cell.profile import DisplayProfile


@dataclass(frozen=True, slots=True, kw_only=True)
class KioskSettings:
    """Settings of a `KioskScreen`.

    Attributes:
        device: Name of the device in messages.
        host: Address the page is served on; only this computer sees the default one.
        port: Port the page is served on, 0 for a free one.
        width_px: Width of the panel; the page must show exactly as many pixels.
        height_px: Height of the panel.
        paint_timeout_s: How long a page may take to be there and to paint a picture.
        state_folder: Where the last picture is kept, so that a new process shows it again;
            None keeps it in memory only.
    """

    device: str = "screen"
    host: str = "127.0.0.1"
    port: int = 8320
    width_px: int = 1920
    height_px: int = 1080
    paint_timeout_s: float = 5.0
    state_folder: Path | None = None

    @classmethod
    def from_profile(
        cls, profile: DisplayProfile, *, port: int | None = None, state_folder: Path | None = None
    ) -> KioskSettings:
        """Return the settings for the television of a profile, on its port unless one is given."""
        return cls(
            port=profile.page_port if port is None else port,
            width_px=profile.width_px,
            height_px=profile.height_px,
            state_folder=state_folder,
        )
