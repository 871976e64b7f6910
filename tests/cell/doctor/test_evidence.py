"""Evidence names what a technician can hold against the device."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from cell.devices.camera import CameraMode
from cell.doctor.checks.cameras import _identity
from cell.errors import DeviceError
from cell.links.settings_text import settings_text
from cell.twin.wire_faults import WireFault
from tests.cell.doctor.seeds import _garbage, _wire
from tests.cell.doctor.ward import mash


@pytest.mark.parametrize("arrange", [_garbage, lambda d, f: _wire(d, WireFault.SILENT, f)])
def test_a_silent_or_spoilt_line_names_the_ports_settings(arrange: partial, tmp_path: Path) -> None:  # type: ignore[type-arg]
    finding = arrange("display", tmp_path).examine("display").findings[0]
    assert any(settings_text(mash().display.serial) in fact for fact in finding.facts)


class ClosedCamera:
    """A camera of hardware that says who it is only when it is open, and cannot be opened."""

    @property
    def identity(self) -> object:
        raise DeviceError("camera top", "is not open", hint="open it in a mode first")

    def open(self, mode: CameraMode) -> None:
        raise DeviceError("camera top", "there is no such device 0")


def test_a_camera_that_cannot_be_opened_says_why() -> None:
    with pytest.raises(DeviceError, match="no such device 0"):
        _identity(ClosedCamera())  # type: ignore[arg-type]
