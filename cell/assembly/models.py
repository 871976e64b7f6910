"""Every model that can be emulated behind a port, by its name in profiles."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

from cell.assembly.emulated import blocks_in_store, emulate_devices
from cell.assembly.wires import serial_lines
from cell.clock import Clock
from cell.errors import ProfileError
from cell.kinematics import SixAxisArm
from cell.profile import (
    CellProfile,
    Ibm7545Profile,
    LynxProfile,
    Profile,
    SerialProfile,
    load_cell_profile,
)
from cell.store import StorePlan, with_calibration_object
from cell.twin.emulators.ibm7545 import RegisterBridge, Slave, SlaveSettings
from cell.twin.emulators.melfa_r3.ethernet import EthernetPort
from cell.twin.emulators.ssc32 import ServoBank, Ssc32Controller, Ssc32ControllerSettings
from cell.twin.wire_faults import FaultyEmulator
from cell.twin.world import World

_PATIENCE_S = 0.25
"""How late a master in real time may be, on a computer that does other things, too."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedDevice:
    """One emulated device and its line.

    Attributes:
        name: Name of the device in the profile.
        model: Its model.
        emulator: The device and its wire's faults.
        line: How its line is set.
        lock: Held while it works; devices of one world have the same.
        on_connect: To be called when a program connects anew, where the device can tell.
    """

    name: str
    model: str
    emulator: FaultyEmulator
    line: SerialProfile
    lock: threading.RLock
    on_connect: Callable[[], None] | None = None


@dataclass(frozen=True, slots=True)
class Model:
    """A model that can be emulated.

    Attributes:
        profile: Shipped profile of a cell that has it.
        device: Its name in the cell.
    """

    profile: str
    device: str


MODELS: dict[str, Model] = {
    "melfa-rv6sdl": Model("mash", "arm"),
    "schunk-pg70": Model("mash", "gripper"),
    "sharp-lc40le705": Model("mash", "display"),
    "ibm-7545": Model("avrs", "arm"),
    "lynx-al5d": Model("lynx", "arm"),
}
"""The models there are."""


def emulate_cell(
    profile: CellProfile, plan: StorePlan, clock: Clock, *, seed: int, on_network: bool = False
) -> tuple[EmulatedDevice, ...]:
    """Return every serial device of a cell, emulated, all acting on one new world.

    Args:
        profile: The cell's profile.
        plan: The store whose blocks are in the world; cells without a playground have none.
        clock: The clock of the world.
        seed: Seed of the world's chance, and of an arm's own errors.
        on_network: Whether a MELFA's controller speaks as at its network port.
    """
    if isinstance(profile, Profile):
        return _playground_devices(profile, plan, clock, seed, on_network=on_network)
    arm = profile.arm
    if isinstance(arm, Ibm7545Profile):
        settings = replace(SlaveSettings.from_profile(arm), lateness_s=_PATIENCE_S)
        bridge = FaultyEmulator(RegisterBridge(Slave(settings), settings), seed=seed)
        return (_lone_arm(arm.model, bridge, arm.serial),)
    if isinstance(arm, LynxProfile):
        controller = Ssc32Controller(
            ServoBank.from_profile(arm, seed=seed), Ssc32ControllerSettings.from_profile(arm)
        )
        return (_lone_arm(arm.model, FaultyEmulator(controller, seed=seed), arm.serial),)
    raise ProfileError(
        f"the profile of {profile.name} has a {arm.model} without a playground; "
        "to emulate it, give the profile of a cell with a gripper, a display and a store"
    )


def emulate_model(
    model: str,
    profile: str | None,
    plan: StorePlan,
    clock: Clock,
    *,
    seed: int,
    on_network: bool = False,
) -> EmulatedDevice:
    """Return one device of a model, emulated in a new world.

    Args:
        model: A key of `MODELS`.
        profile: Name or path of a profile that has it; the shipped one unless given.
        plan: The store whose blocks are in the world.
        clock: The clock of the world.
        seed: Seed of the world's chance, and of an arm's own errors.
        on_network: Whether it is reached over TCP: the MELFA's controller then speaks as at
            its network port, other devices as through a converter on their serial line.

    Raises:
        ProfileError: The profile cannot be used, or has no such model.
    """
    known = MODELS[model]
    used = load_cell_profile(profile or known.profile)
    for device in emulate_cell(used, plan, clock, seed=seed, on_network=on_network):
        if device.model == model:
            return device
    raise ProfileError(
        f"the profile {profile} has no {model}; "
        f"the shipped profile {known.profile} has one as its {known.device}"
    )


def _playground_devices(
    profile: Profile, plan: StorePlan, clock: Clock, seed: int, *, on_network: bool
) -> tuple[EmulatedDevice, ...]:
    kinematics = SixAxisArm.from_profile(profile.arm)
    plan = with_calibration_object(plan, profile.store)
    world = World(profile, kinematics, clock, blocks_in_store(profile, plan), seed=seed)
    devices = emulate_devices(profile, world, kinematics, seed=seed)
    lock = threading.RLock()
    models = {
        "arm": profile.arm.model,
        "gripper": profile.gripper.model,
        "display": profile.display.model,
    }
    wires = dict(devices.wires)
    on_connect: dict[str, Callable[[], None]] = {}
    if on_network:
        port = EthernetPort(devices.controller)
        wires["arm"] = FaultyEmulator(port, seed=seed)
        on_connect["arm"] = port.connect
    return tuple(
        EmulatedDevice(
            name=name,
            model=models[name],
            emulator=wires[name],
            line=line,
            lock=lock,
            on_connect=on_connect.get(name),
        )
        for name, line in serial_lines(profile).items()
    )


def _lone_arm(model: str, emulator: FaultyEmulator, line: SerialProfile) -> EmulatedDevice:
    return EmulatedDevice(
        name="arm", model=model, emulator=emulator, line=line, lock=threading.RLock()
    )
