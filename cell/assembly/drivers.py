"""The drivers of a cell on its links; they do not know what is at the other end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from cell.clock import Clock
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.drivers.schunk_smp.driver import SchunkGripper
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.drivers.sharp_aquos.driver import SharpDisplay
from cell.drivers.sharp_aquos.settings import SharpSettings
from cell.links.base import Link
from cell.profile import Profile
from cell.stop import StopToken


@dataclass(frozen=True, slots=True)
class Drivers:
    """The drivers of a cell's serial devices."""

    arm: MelfaArm
    gripper: SchunkGripper
    display: SharpDisplay


def make_drivers(
    profile: Profile,
    links: Mapping[str, Link],
    clock: Clock,
    stop: StopToken,
    *,
    on_warning: Callable[[str], None],
    on_repeat: Callable[[str, str], None],
) -> Drivers:
    """Return the drivers of a profile's devices.

    Args:
        profile: The cell's profile.
        links: The link of each device: `arm`, `gripper`, `display`.
        clock: The clock of everything in the cell.
        stop: Ends what takes long.
        on_warning: Told when a driver opens that was never tried on hardware.
        on_repeat: Told the device and what was wrong, whenever a request is sent again.
    """
    return Drivers(
        arm=MelfaArm(
            links["arm"],
            clock,
            ArmSettings.from_profile(profile.arm),
            on_warning=on_warning,
            on_repeat=on_repeat,
        ),
        gripper=SchunkGripper(
            links["gripper"],
            clock,
            SchunkSettings.from_profile(profile.gripper),
            token=stop,
            on_warning=on_warning,
            on_repeat=on_repeat,
        ),
        display=SharpDisplay(
            links["display"],
            clock,
            SharpSettings.from_profile(profile.display),
            on_warning=on_warning,
            on_repeat=on_repeat,
        ),
    )
