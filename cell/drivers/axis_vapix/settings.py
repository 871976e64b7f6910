"""What the web camera's driver must be told beside its table in the profile."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisSettings:
    """Settings of an `AxisCamera`.

    Attributes:
        device: Name of the device in messages.
        user_agent: How the driver introduces itself; some models only answer browsers.
        part_timeout_s: How long a stream may go without a whole picture.
        stream_attempts: How often in a row a stream is opened anew before it is given up.
        least_back_off_s: Pause before the first new attempt; doubled with each.
        most_back_off_s: Longest pause.
        poll_s: Time between two questions where the head is.
        still_deg: Largest change between two questions of a head that stands.
        travel_timeout_s: How long a head may take to come to rest.
    """

    device: str = "web camera"
    user_agent: str = "Mozilla/5.0 (compatible; robocell)"
    part_timeout_s: float = 2.5
    stream_attempts: int = 5
    least_back_off_s: float = 0.25
    most_back_off_s: float = 4.0
    poll_s: float = 0.5
    still_deg: float = 0.05
    travel_timeout_s: float = 20.0

    def back_off_s(self, failures: int) -> float:
        """Return the pause after so many failures in a row."""
        longer_s: float = self.least_back_off_s * 2.0 ** min(failures - 1, 30)
        return min(self.most_back_off_s, longer_s)
