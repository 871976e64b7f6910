"""What a serial link says when a port cannot be had, or is lost."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from cell.clock import SimulatedClock
from cell.errors import LinkError
from cell.links.errors import (
    DeviceVanished,
    NotReached,
    PortForbidden,
    PortMissing,
    PortTaken,
    SettingsRefused,
)
from cell.links.opening import lazy_link
from cell.links.ports import present_ports
from cell.links.serial import SerialLink
from cell.links.tcp import TcpLink
from cell.profile import SerialProfile, TcpProfile
from cell.twin.serving.pty_port import PtyPort


def _line(port: object, usb_serial: str = "") -> SerialProfile:
    return SerialProfile(
        port=str(port), usb_serial=usb_serial, baud=38400, parity="even", stop_bits=2
    )


@pytest.fixture
def port(tmp_path: Path) -> Iterator[PtyPort]:
    made = PtyPort(tmp_path / "arm", _line(tmp_path / "arm"))
    yield made
    made.unplug()


@pytest.fixture
def adapter(monkeypatch: pytest.MonkeyPatch, port: PtyPort) -> ListPortInfo:
    info = ListPortInfo(str(port.path))
    info.serial_number, info.description, info.vid, info.pid = "A700F1", "USB-RS232", 1027, 24577
    monkeypatch.setattr(list_ports, "comports", lambda: [info])
    return info


def test_a_port_that_there_is_not_is_told_with_those_there_are(
    tmp_path: Path, adapter: ListPortInfo
) -> None:
    with pytest.raises(PortMissing, match=r"gripper: no port .*COM9.*A700F1"):
        SerialLink("gripper", _line(tmp_path / "COM9"))


def test_a_usb_serial_number_finds_its_port(adapter: ListPortInfo, port: PtyPort) -> None:
    link = SerialLink("arm", _line("COM1", usb_serial="A700F1"))
    assert link.port.port == str(port.path)
    link.close()
    (found,) = present_ports()
    assert (found.usb_serial, found.description, found.vendor_id) == ("A700F1", "USB-RS232", 1027)


def test_a_usb_serial_number_that_is_not_plugged_in_is_told(adapter: ListPortInfo) -> None:
    with pytest.raises(PortMissing, match="USB serial number B2"):
        SerialLink("arm", _line("", usb_serial="B2"))


def test_a_port_that_another_has_is_told(port: PtyPort) -> None:
    first = SerialLink("arm", _line(port.path))
    with pytest.raises(PortTaken, match="arm: another program has port"):
        SerialLink("arm", _line(port.path))
    first.close()
    port.greet()
    SerialLink("arm", _line(port.path)).close()


def test_a_port_that_may_not_be_opened_is_told(
    port: PtyPort, monkeypatch: pytest.MonkeyPatch
) -> None:
    really = os.open

    def refuse(path: str, flags: int, mode: int = 0o777) -> int:
        if path == str(port.path):
            raise PermissionError(13, "Permission denied")
        return really(path, flags, mode)

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(PortForbidden, match="dialout"):
        SerialLink("arm", _line(port.path))


def test_what_is_no_serial_port_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no port")
    with pytest.raises(SettingsRefused, match="38400 8E2"):
        SerialLink("arm", _line(tmp_path / "file"))


def test_settings_that_change_nothing_visible_are_refused_by_the_system_and_told(
    port: PtyPort,
) -> None:
    SerialLink("arm", _line(port.path)).close()
    with pytest.raises(SettingsRefused, match="Invalid argument"):
        SerialLink("arm", _line(port.path))


def test_a_device_that_vanishes_while_open_is_told(port: PtyPort) -> None:
    link = SerialLink("arm", _line(port.path))
    port.unplug()
    with pytest.raises(DeviceVanished, match="arm: .* is gone"):
        link.write(b"?")
    with pytest.raises(DeviceVanished, match="arm: .* is gone"):
        link.read(0.0)
    link.close()


def test_nobody_at_a_network_address_is_told() -> None:
    profile = TcpProfile(host="127.0.0.1", port=9, connect_timeout_s=1.0)
    with pytest.raises(NotReached, match=r"arm: no connection to 127\.0\.0\.1:9"):
        TcpLink("arm", profile)


def test_a_missing_port_is_an_error_of_the_first_use_only(tmp_path: Path) -> None:
    clock = SimulatedClock()
    link = lazy_link("arm", _line(tmp_path / "COM9"), clock)
    for _ in range(2):
        with pytest.raises(LinkError, match="arm: no port"):
            link.write(b"?")
    assert clock.now_s() == 0.0
