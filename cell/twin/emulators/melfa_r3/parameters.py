"""Parameters of the emulated controller, in the layout of a PNR reply."""

from __future__ import annotations

from cell.twin.emulators.melfa_r3.settings import ControllerSettings

_UNLIMITED_MM = 10000.0


def parameter_values(settings: ControllerSettings, name: str) -> tuple[str, ...] | None:
    """Return the values of a parameter, None if there is no such parameter."""
    if name == "MEJAR":
        pairs = zip(settings.joint_min_deg, settings.joint_max_deg, strict=True)
        return _printed([limit for pair in pairs for limit in pair])
    if name == "MEPAR":
        free = (-_UNLIMITED_MM, _UNLIMITED_MM)
        return _printed([*free, *free, settings.flange_min_z_mm, _UNLIMITED_MM])
    if name == "MEXTL":
        return _printed([*settings.tool_mm, 0.0, 0.0, 0.0])
    if name == "JSAFE":
        return _printed(list(settings.safe_deg))
    return None


def _printed(values: list[float]) -> tuple[str, ...]:
    return tuple([f"{value:.2f}" for value in values])
