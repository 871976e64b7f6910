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

from cell.assembly.wires import TwinWires
from cell.clock import Clock
from cell.devices.arm import OpenableArm
from cell.drivers.ibm7545.bus import BridgedBus
from cell.drivers.ibm7545.driver import Ibm7545Arm
from cell.drivers.ibm7545.gripper import RegisterGripper
from cell.drivers.ibm7545.settings import ScaraSettings
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.drivers.ssc32.gripper import Ssc32Gripper
from cell.drivers.ssc32.line import straight_line
from cell.drivers.ssc32.settings import FingerSettings, Ssc32Settings
from cell.errors import CellError, ProfileError
from cell.events import EventBus
from cell.kinematics.line import joints_along_line
from cell.kinematics.lynx import LynxArm
from cell.kinematics.scara import ScaraArm
from cell.links.base import Emulator, Link, Tap
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.links.opening import lazy_link, open_wire
from cell.links.reconnecting import ReconnectingLink
from cell.lock import CellLock
from cell.motion.chain_guard import ChainGuard
from cell.motion.chain_hull import ChainShape
from cell.motion.guarded import GuardedArm
from cell.profile import BoxProfile, CellProfile
from cell.profile.ibm7545 import Ibm7545Profile
from cell.profile.lynx import LynxProfile
from cell.recovery.arm_resume import ArmResumeCheck, BlindFingers, Straying
from cell.recovery.watched_gripper import WatchedGripper
from cell.reporting import FaultReporter
from cell.stop import StopToken
from cell.twin.emulators.ibm7545 import RegisterBridge, Slave, SlaveSettings
from cell.twin.emulators.ssc32 import ServoBank, Ssc32Controller, Ssc32ControllerSettings
from cell.twin.keeping_arm import ArmEmulator, ArmFile, KeptEmulator
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.stepped import SteppedWire
from cell.twin.wire_faults import FaultyEmulator

LYNX_SHAPE = ChainShape(radii_mm=(0.0, 35.0, 35.0, 30.0), tip_mm=15.0, loaded_tip_mm=25.0)
"""Links of the Lynx between base, shoulder, elbow, wrist and tool point; estimated. The tool
point lies between the fingertips, which reach past it, and so does half a held cube."""
_SCARA_OPEN_MM = 30.0
"""Opening of the pneumatic fingers; no source gives it."""

_LYNX_STRAYING = Straying(within_mm=20.0, within=2.5)
"""A stopped Lynx stands within 10 us (about 1 deg) a joint of where its pulses were."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmStation:
    """An arm with its gripper, ready to be opened: a cell without a playground.

    Attributes:
        profile: The cell's profile.
        clock: Its clock.
        events: Where its events go.
        stop: Ends what takes long.
        arm: The arm; every motion passes its guard, and the resume check after a fault.
        driver: The arm itself, for everything but motion.
        gripper: Its gripper, on the same wire, or None where the profile has none.
        confirm_grip: Says that somebody looked at the fingers after a fault: they measure
            nothing. It holds for the next resume check that is clear.
        dispose: Closes the wire and gives the cell back; calling it twice is harmless.
    """

    profile: CellProfile
    clock: Clock
    events: EventBus
    stop: StopToken
    arm: GuardedArm
    driver: Ibm7545Arm | Ssc32Arm
    gripper: WatchedGripper | None
    confirm_grip: Callable[[], None]
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


@dataclass(frozen=True, slots=True, kw_only=True)
class _Site:
    """What a station is put together with."""

    profile: CellProfile
    clock: Clock
    events: EventBus
    stop: StopToken
    tap: Tap | None
    on_warning: Callable[[str], None]


def twin_arm(
    profile: CellProfile,
    *,
    clock: Clock,
    seed: int = 0,
    tap: Tap | None = None,
    events: EventBus | None = None,
    stop: StopToken | None = None,
    wires: TwinWires = "memory",
    state_folder: Path | None = None,
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
        state_folder: Where the arm is kept from one process to the next, powered all the
            time; None keeps it in memory, freshly powered.

    Raises:
        ProfileError: The profile has another arm.
        StillHeld: Another process has this cell.
        CellError: What is kept in the folder cannot be used.
    """
    site = _Site(
        profile=profile, clock=clock, events=events or EventBus(clock), stop=stop or StopToken(),
        tap=tap, on_warning=_unheard,
    )  # fmt: skip
    emulator = _emulator(profile, seed)
    release, kept = _keep(emulator, state_folder, clock)
    wire = FaultyEmulator(kept, seed=seed)
    if wires == "memory":
        link: Link = MemoryLink("arm", wire, clock)
        close = link.close
    else:
        link, close = _over_pty(profile, wire, clock, site.stop)
    station = _station(site, link, _each_once(close, release))
    return TwinArmStation(
        profile=station.profile,
        clock=station.clock,
        events=station.events,
        stop=station.stop,
        arm=station.arm,
        driver=station.driver,
        gripper=station.gripper,
        confirm_grip=station.confirm_grip,
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
    state_folder: Path | None = None,
) -> ArmStation:
    """Put the arm of a cell together on the port of its profile, which is opened when used.

    Args:
        profile: The cell's profile; its arm is an IBM 7545 or a Lynx.
        clock: The clock of the driver.
        on_warning: Told what a technician should know although nothing failed.
        tap: Shown every byte on the wire.
        events: Where events go; a bus of its own unless given.
        stop: Ends what takes long.
        state_folder: Whose lock says that the cell is in use; None takes no lock.

    Raises:
        ProfileError: The profile has another arm.
        StillHeld: Another process has this cell.
    """
    site = _Site(
        profile=profile, clock=clock, events=events or EventBus(clock), stop=stop or StopToken(),
        tap=tap, on_warning=on_warning,
    )  # fmt: skip
    link = lazy_link("arm", _own(profile).serial, clock, token=site.stop)
    lock = None if state_folder is None else CellLock(state_folder)
    release = _nothing if lock is None else lock.release
    return _station(site, link, _each_once(link.close, release))


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


def _station(site: _Site, link: Link, dispose: Callable[[], None]) -> ArmStation:
    figures, guard = _own(site.profile), chain_guard(site.profile)
    wire = link if site.tap is None else CapturedLink(link, site.tap)
    driver, fingers = _drivers(figures, wire, site.clock, site.stop, site.on_warning)
    arm = GuardedArm(driver, guard, figures, site.events, site.stop)
    reporter = FaultReporter(site.events)
    checks: list[ArmResumeCheck] = []

    def make_gate(opened: OpenableArm) -> ArmResumeCheck:
        check = ArmResumeCheck(
            figures,
            arm=opened,
            reopen=driver.reopen if figures.enabled else lambda: None,
            kinematics=guard.arm,
            guard=guard,
            fingers=fingers,
            straying=_LYNX_STRAYING if isinstance(figures, LynxProfile) else Straying(),
            reporter=reporter,
        )
        checks.append(check)
        return check

    arm.pass_through(make_gate)
    return ArmStation(
        profile=site.profile,
        clock=site.clock,
        events=site.events,
        stop=site.stop,
        arm=arm,
        driver=driver,
        gripper=None if fingers is None else _watched(fingers, arm, reporter),
        confirm_grip=checks[0].confirm_grip,
        dispose=dispose,
    )


def _watched(fingers: BlindFingers, arm: GuardedArm, reporter: FaultReporter) -> WatchedGripper:
    return WatchedGripper(
        fingers.gripper,
        arm,
        may_hold_block=fingers.may_hold,
        power_up=_nothing,
        reporter=reporter,
    )


def _drivers(
    arm: Ibm7545Profile | LynxProfile,
    link: Link,
    clock: Clock,
    stop: StopToken,
    on_warning: Callable[[str], None],
) -> tuple[Ibm7545Arm | Ssc32Arm, BlindFingers | None]:
    if isinstance(arm, Ibm7545Profile):
        scara = Ibm7545Arm(
            BridgedBus(link, clock),
            ScaraArm.from_profile(arm),
            clock,
            ScaraSettings.from_profile(arm),
            token=stop,
            on_warning=on_warning,
        )
        valve = RegisterGripper(scara.outputs, open_mm=_SCARA_OPEN_MM, on_warning=on_warning)
        return scara, BlindFingers(gripper=valve, open_mm=_SCARA_OPEN_MM, limp_is_empty=False)
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
    servo = Ssc32Gripper(link, clock, settings, on_warning=on_warning, token=stop)
    return lynx, BlindFingers(gripper=servo, open_mm=settings.open_mm, limp_is_empty=True)


def _keep(
    emulator: ArmEmulator, folder: Path | None, clock: Clock
) -> tuple[Callable[[], None], Emulator]:
    """Lock and load a kept arm; return what keeps it and gives it back, and what to talk to."""
    if folder is None:
        return _nothing, emulator
    lock, file = CellLock(folder), ArmFile(folder / "arm.json")
    try:
        file.load_into(emulator)
    except CellError:
        lock.release()
        raise

    def release() -> None:
        file.save(emulator, clock.now_s())
        lock.release()

    return release, KeptEmulator(emulator, file)


def _each_once(*deeds: Callable[[], None]) -> Callable[[], None]:
    """Return what does several things, however often it is called only once."""
    left = list(deeds)

    def run() -> None:
        while left:
            left.pop(0)()

    return run


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


def _nothing() -> None:
    """Do nothing."""


def _unheard(warning: str) -> None:
    """Take a driver's warning that it was never tried on hardware: here is none."""
