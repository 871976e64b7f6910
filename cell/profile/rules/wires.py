"""Ports: each has one device, and one that is given is used."""

from __future__ import annotations

from collections.abc import Iterator

from cell.profile.arms import MelfaProfile
from cell.profile.cell import CellProfile, Profile
from cell.profile.devices import DisplayProfile, GripperProfile
from cell.profile.rules.problem import Problem, Rule
from cell.profile.wires import SerialProfile


def _ports(profile: CellProfile) -> list[tuple[str, SerialProfile]]:
    """Return the serial ports that are used, by device."""
    wires: list[tuple[str, SerialProfile]] = []
    arm = profile.arm
    if arm.enabled and not (isinstance(arm, MelfaProfile) and arm.tcp is not None):
        wires.append(("arm", arm.serial))
    if isinstance(profile, Profile):
        wires += [(n, d.serial) for n, d in _serial_devices(profile) if d.enabled]
    return wires


def _serial_devices(profile: Profile) -> Iterator[tuple[str, GripperProfile | DisplayProfile]]:
    """Yield the devices beside the arm; one whose table is not sound is not there."""
    for name in ("gripper", "display"):
        device = profile.__dict__.get(name)
        if isinstance(device, (GripperProfile, DisplayProfile)):
            yield name, device


def _shared_ports(profile: CellProfile) -> Iterator[Problem]:
    """A serial port has one device; disabled ones do not count, nor the port of an arm on TCP."""
    taken: dict[tuple[str, str], str] = {}
    for device, serial in _ports(profile):
        for field, value in (("port", serial.port), ("usb_serial", serial.usb_serial)):
            if field == "usb_serial" and serial.port:
                continue  # An adapter with several ports has one serial number.
            owner = taken.setdefault((field, value.casefold()), device) if value else device
            if owner != device:
                yield Problem(
                    (device, "serial", field),
                    f'{device} and {owner} are both at "{value}"; a port has one device',
                    f"give {device} or {owner} its own port",
                    other=(owner, "serial", field),
                )


def _unused(profile: CellProfile) -> Iterator[Problem]:
    """Warning: a port that nothing uses, or a device in use without one."""
    arm = profile.arm
    if isinstance(arm, MelfaProfile) and arm.tcp is not None and arm.serial.port:
        yield Problem(
            ("arm", "serial", "port"),
            f'the port "{arm.serial.port}" is not used: the arm is reached at '
            f"{arm.tcp.host}:{arm.tcp.port}",
            other=("arm", "tcp"),
            severity="warning",
        )
    devices = [("arm", arm.enabled, arm.serial)]
    if isinstance(profile, Profile):
        devices += [(n, d.enabled, d.serial) for n, d in _serial_devices(profile)]
    for device, is_enabled, serial in devices:
        if not is_enabled and serial.port:
            yield Problem(
                (device, "serial", "port"),
                f'the port "{serial.port}" is not used: {device} is disabled',
                other=(device, "enabled"),
                severity="warning",
            )
    for device, serial in _ports(profile):
        if not (serial.port or serial.usb_serial):
            yield Problem(
                (device, "serial"),
                f"{device} has neither port nor usb_serial: only its twin can be used",
                "`cell profile new` on a terminal offers the ports that there are",
                severity="warning",
            )


WIRE_RULES = (Rule(("arm",), _shared_ports), Rule(("arm",), _unused))
