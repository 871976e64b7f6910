"""What an emulated IBM 7545 is like. No source gives its dynamics: these figures are ours.

They are chosen so that the source's gains and speeds work as it says they do: with kp 60
and kv 0.1 the loop's natural frequency is about 57 Hz, and at full speed a joint runs some
20 pulses behind, two thirds of the torque range.
"""

from __future__ import annotations

from dataclasses import dataclass

from cell.drivers.ibm7545.registers import OVERRUN_MAX, OVERRUN_MIN
from cell.profile.ibm7545 import Four, Ibm7545Profile
from cell.twin.emulators.uart import line_byte_s


@dataclass(frozen=True, slots=True, kw_only=True)
class SlaveSettings:
    """Figures of one emulated slave, its motors and joints. Positions are pulses.

    Attributes:
        acceleration: Of each joint, pulses/s² for each torque count.
        viscous: Share of its speed that a joint loses a second, 1/s: motor and gears.
        coulomb: Friction of each joint in torque counts, moving or about to.
        start: Where the joints stand at power-up, from home.
        stop_min: Where each joint meets its lower end stop.
        stop_max: Where each joint meets its upper end stop.
        overrun_min: Below which the slave sets the negative overrun bit.
        overrun_max: Above which it sets the positive one.
        homing_speed: Speed of each joint on its way home, pulses/s.
        measure_s: From a period's start to the state's registers being ready.
        gripper_s: How long the slave is busy with the gripper.
        lateness_s: How much longer than its period the slave waits for its master. The
            slave of metal does not wait at all; a master in real time on a busy computer
            needs it.
        byte_s: Time of a byte on the bridge's line.
        processing_s: The bridge's own time for a request.
    """

    acceleration: Four = (2160.0, 2160.0, 2160.0, 2160.0)
    viscous: Four = (50.0, 50.0, 50.0, 50.0)
    coulomb: Four = (25.0, 25.0, 40.0, 25.0)
    start: tuple[int, int, int, int] = (60000, 30000, 20000, 4000)
    stop_min: Four = (-6000.0, -3500.0, -900.0, -45000.0)
    stop_max: Four = (178000.0, 61500.0, 96500.0, 45000.0)
    overrun_min: tuple[int, int, int, int] = OVERRUN_MIN
    overrun_max: tuple[int, int, int, int] = OVERRUN_MAX
    homing_speed: Four = (13000.0, 6600.0, 19000.0, 4500.0)
    measure_s: float = 0.00015
    gripper_s: float = 0.5
    lateness_s: float = 0.0
    byte_s: float = 10 / 3_000_000
    processing_s: float = 0.00002

    @staticmethod
    def from_profile(profile: Ibm7545Profile) -> SlaveSettings:
        """Return the settings of the arm that a profile describes."""
        return SlaveSettings(byte_s=line_byte_s(profile.serial))
