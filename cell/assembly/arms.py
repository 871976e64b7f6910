"""The arm of any cell, guarded, on its twin or on hardware.

For arms that have no playground around them: the IBM 7545 of the avrs cell and the Lynx.
Here meet what nobody else may know together: profile, driver, emulator, guard.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeAlias

from cell.assembly.wires import TwinWires
from cell.clock import Clock
from cell.devices.arm import Arm
from cell.devices.gripper import Gripper
from cell.drivers.ibm7545.bus import BridgedBus
from cell.drivers.ibm7545.driver import Ibm7545Arm
from cell.drivers.ibm7545.gripper import RegisterGripper
from cell.drivers.ibm7545.settings import ScaraSettings
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.drivers.ssc32.gripper import Ssc32Gripper
from cell.drivers.ssc32.line import straight_line
from cell.drivers.ssc32.settings import FingerSettings, Ssc32Settings
from cell.errors import ProfileError
from cell.events import EventBus
from cell.kinematics.line import joints_along_line
from cell.kinematics.lynx import LynxArm
from cell.kinematics.scara import ScaraArm
from cell.links.base import Link, Tap
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.links.opening import lazy_link, open_wire
from cell.links.reconnecting import ReconnectingLink
from cell.motion.chain_guard import ChainGuard
from cell.motion.chain_hull import ChainShape
from cell.motion.guarded import GuardedArm
from cell.profile import BoxProfile, CellProfile
from cell.profile.ibm7545 import Ibm7545Profile
from cell.profile.lynx import LynxProfile
from cell.stop import StopToken
from cell.twin.emulators.ibm7545 import RegisterBridge, Slave, SlaveSettings
from cell.twin.emulators.ssc32 import ServoBank, Ssc32Controller, Ssc32ControllerSettings
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.stepped import SteppedWire
from cell.twin.wire_faults import FaultyEmulator

LYNX_SHAPE = ChainShape(radii_mm=(0.0, 35.0, 35.0, 30.0), tip_mm=15.0, loaded_tip_mm=25.0)
"""Links of the Lynx between base, shoulder, elbow, wrist and tool point; estimated. The tool
point lies between the fingertips, which reach past it, and so does half a held cube."""
_SCARA_OPEN_MM = 30.0
"""Opening of the pneumatic fingers; no source gives it."""

ArmEmulator: TypeAlias = RegisterBridge | Ssc32Controller


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmStation:
    """An arm with its gripper, ready to be opened.

    Attributes:
        guarded: The arm; every motion passes its guard.
        arm: The arm itself, for everything but motion.
        gripper: Its gripper, on the same wire, or None where the profile has none.
        dispose: Closes the wire; calling it twice is harmless.
    """

    guarded: GuardedArm
    arm: Arm
    gripper: Gripper | None
    dispose: Callable[[], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinArmStation(ArmStation):
    """An arm on its twin.

    Attributes:
        emulator: The device behind the wire, whose buttons can be pressed.
        wire: The wire, which can be made to fail.
    """

    emulator: ArmEmulator
    wire: FaultyEmulator


def twin_arm(
    profile: CellProfile,
    *,
    clock: Clock,
    seed: int = 0,
    tap: Tap | None = None,
    events: EventBus | None = None,
    stop: StopToken | None = None,
    wires: TwinWires = "memory",
) -> TwinArmStation:
    """Put the arm of a cell together on its emulator.

    Args:
        profile: The cell's profile; its arm is an IBM 7545 or a Lynx.
        clock: The clock of driver and emulator.
        seed: Seed of what is random in the emulator and its wire.
        tap: Shown every byte on the wire.
        events: Where events go; a bus of its own unless given.
        stop: Ends what takes long.
        wires: In memory, or behind a pseudo-terminal that pyserial opens.

    Raises:
        ProfileError: The profile has another arm.
    """
    stop = stop or StopToken()
    emulator = _emulator(profile, seed)
    wire = FaultyEmulator(emulator, seed=seed)
    if wires == "memory":
        link: Link = MemoryLink("arm", wire, clock)
        dispose = link.close
    else:
        link, dispose = _over_pty(profile, wire, clock, stop)
    station = _station(profile, link, dispose, clock, tap, events, stop, on_warning=_unheard)
    return TwinArmStation(
        guarded=station.guarded,
        arm=station.arm,
        gripper=station.gripper,
        dispose=station.dispose,
        emulator=emulator,
        wire=wire,
    )


def hardware_arm(
    profile: CellProfile,
    *,
    clock: Clock,
    on_warning: Callable[[str], None],
    tap: Tap | None = None,
    events: EventBus | None = None,
    stop: StopToken | None = None,
) -> ArmStation:
    """Put the arm of a cell together on the port of its profile, which is opened when used.

    Raises:
        ProfileError: The profile has another arm.
    """
    stop = stop or StopToken()
    link = lazy_link("arm", _own(profile).serial, clock, token=stop)
    return _station(profile, link, link.close, clock, tap, events, stop, on_warning=on_warning)


def chain_guard(profile: CellProfile) -> ChainGuard:
    """Return the guard of a cell whose arm is an IBM 7545 or a Lynx.

    Raises:
        ProfileError: The profile has another arm.
    """
    arm = _own(profile)
    if isinstance(arm, Ibm7545Profile):
        return scara_guard(arm, profile.boxes)
    kinematics = LynxArm.from_profile(arm)
    return ChainGuard(
        kinematics,
        LYNX_SHAPE,
        partial(straight_line, kinematics),
        boxes=profile.boxes,
        max_linear_speed_mm_s=arm.max_linear_speed_mm_s,
    )


def scara_guard(arm: Ibm7545Profile, boxes: tuple[BoxProfile, ...]) -> ChainGuard:
    """Return the guard of an IBM 7545 among boxes."""
    kinematics = ScaraArm.from_profile(arm)
    link, tool = arm.link_radius_mm, arm.tool_radius_mm
    space = arm.work_space
    return ChainGuard(
        kinematics,
        # What it grips ends flush with its fingers.
        ChainShape(radii_mm=(0.0, link, link, tool), tip_mm=0.0, loaded_tip_mm=0.0),
        partial(joints_along_line, kinematics),
        boxes=boxes,
        max_linear_speed_mm_s=arm.max_linear_speed_mm_s,
        work_space=None if space is None else (*space.min_mm, *space.max_mm),
    )


def _own(profile: CellProfile) -> Ibm7545Profile | LynxProfile:
    arm = profile.arm
    if isinstance(arm, Ibm7545Profile | LynxProfile):
        return arm
    raise ProfileError(
        f"the cell {profile.name} has a {arm.model}; this assembles ibm-7545 and lynx-al5d, "
        "use assemble_twin or assemble_hardware"
    )


def _emulator(profile: CellProfile, seed: int) -> ArmEmulator:
    arm = _own(profile)
    if isinstance(arm, Ibm7545Profile):
        settings = SlaveSettings.from_profile(arm)
        return RegisterBridge(Slave(settings), settings)
    bank = ServoBank.from_profile(arm, seed=seed)
    return Ssc32Controller(bank, Ssc32ControllerSettings.from_profile(arm))


def _station(
    profile: CellProfile,
    link: Link,
    dispose: Callable[[], None],
    clock: Clock,
    tap: Tap | None,
    events: EventBus | None,
    stop: StopToken,
    *,
    on_warning: Callable[[str], None],
) -> ArmStation:
    arm, guard = _own(profile), chain_guard(profile)
    wire = link if tap is None else CapturedLink(link, tap)
    driver, gripper = _drivers(arm, wire, clock, stop, on_warning)
    return ArmStation(
        guarded=GuardedArm(driver, guard, arm, events or EventBus(clock), stop),
        arm=driver,
        gripper=gripper,
        dispose=dispose,
    )


def _drivers(
    arm: Ibm7545Profile | LynxProfile,
    link: Link,
    clock: Clock,
    stop: StopToken,
    on_warning: Callable[[str], None],
) -> tuple[Arm, Gripper | None]:
    if isinstance(arm, Ibm7545Profile):
        scara = Ibm7545Arm(
            BridgedBus(link, clock),
            ScaraArm.from_profile(arm),
            clock,
            ScaraSettings.from_profile(arm),
            token=stop,
            on_warning=on_warning,
        )
        fingers = RegisterGripper(scara.outputs, open_mm=_SCARA_OPEN_MM, on_warning=on_warning)
        return scara, fingers
    lynx = Ssc32Arm(
        link,
        clock,
        Ssc32Settings.from_profile(arm),
        LynxArm.from_profile(arm),
        on_warning=on_warning,
        token=stop,
    )
    if not arm.fingers.enabled:
        return lynx, None
    settings = FingerSettings.from_profile(arm)
    return lynx, Ssc32Gripper(link, clock, settings, on_warning=on_warning, token=stop)


def _over_pty(
    profile: CellProfile, emulator: FaultyEmulator, clock: Clock, stop: StopToken
) -> tuple[Link, Callable[[], None]]:
    folder = tempfile.TemporaryDirectory(prefix="robocell-ports-")
    path = Path(folder.name) / "arm"
    line = _own(profile).serial.model_copy(update={"port": str(path), "usb_serial": ""})
    wire = SteppedWire(emulator, PtyPort(path, line), clock)
    link = ReconnectingLink(
        "arm", lambda: wire.open(lambda: open_wire("arm", line)), clock, token=stop
    )

    def dispose() -> None:
        link.close()
        wire.close()
        folder.cleanup()

    return link, dispose


def _unheard(warning: str) -> None:
    """Take a driver's warning that it was never tried on hardware: here is none."""
