"""The parameters of a serial line as technicians write them."""

from __future__ import annotations

from cell.profile import SerialProfile


def settings_text(profile: SerialProfile) -> str:
    """Return the parameters of a line, such as `38400 8E2`."""
    letter = profile.parity[0].upper()
    flow = "" if profile.flow_control == "none" else f" {profile.flow_control}"
    return f"{profile.baud} {profile.data_bits}{letter}{profile.stop_bits}{flow}"
