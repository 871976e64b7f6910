"""How the emulated web camera is made and set."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

AuthMode: TypeAlias = Literal["none", "basic", "digest", "both"]


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedAxisSettings:
    """Settings of an `EmulatedAxisCamera`.

    Attributes:
        auth: What the camera wants to see of who asks.
        user: The one user there is.
        password: The user's password.
        nonce_uses: How often a digest's nonce may be used before it is old.
        needs_browser: Whether only a browser's user agent is answered.
        has_head: Whether it turns and zooms; without it there is no ptz.cgi.
        has_head_driver: Whether the head is set up; without it ptz.cgi only complains.
        tells_name: Whether the user may read parameters.
        product: Full name of the product.
        quotes_boundary: Whether the stream's header names the boundary in quotes.
        names_dashes: Whether the stream's header names the boundary with its dashes.
        tells_length: Whether a part of a stream tells its length.
        rate_hz: Pictures a second of a stream that asks for none.
        most_viewers: How many streams run at a time.
        pan_deg: How far it pans.
        tilt_deg: How far it tilts.
        speed_deg_s: How fast the head turns at full speed.
        zoom_s: Seconds from one end of the zoom to the other.
        step_deg: How far a step in a direction goes.
        angle_of_view_deg: Horizontal angle of view at zoom 1.
        most_zoom: How many times the picture is enlarged at zoom 9999.
        presets: Stored positions by name: pan, tilt, zoom.
    """

    auth: AuthMode = "none"
    user: str = "root"
    password: str = "pass"
    nonce_uses: int = 1000
    needs_browser: bool = False
    has_head: bool = True
    has_head_driver: bool = True
    tells_name: bool = True
    product: str = "AXIS 211 PTZ Network Camera"
    quotes_boundary: bool = False
    names_dashes: bool = False
    tells_length: bool = True
    rate_hz: float = 10.0
    most_viewers: int = 20
    pan_deg: tuple[float, float] = (-170.0, 170.0)
    tilt_deg: tuple[float, float] = (-90.0, 10.0)
    speed_deg_s: float = 100.0
    zoom_s: float = 3.0
    step_deg: float = 5.0
    angle_of_view_deg: float = 50.0
    most_zoom: float = 18.0
    presets: dict[str, tuple[float, float, int]] = field(
        default_factory=lambda: {
            "Home": (0.0, 0.0, 1),
            "table": (10.0, -40.0, 1500),
            "store": (-60.0, -35.0, 2500),
        }
    )
