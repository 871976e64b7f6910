"""How a controller is reached without moving its arm: what differs from arm to arm."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Protocol

from cell.devices.arm import ArmSignals
from cell.drivers.ibm7545.driver import Ibm7545Arm
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.errors import DeviceRestarted
from cell.profile import MelfaProfile

_CLIENT: Final = "BYHAND"

PutBack = Callable[[], None]


class Reaching(Protocol):
    """Reaching a controller while its arm stays as it is.

    Attributes:
        closed_words: How the arm stays behind when it was closed, for people.
        keeps_servos: Whether its servos can be left on, or go off with the program.
    """

    closed_words: str
    keeps_servos: bool

    def reach(self) -> PutBack | None:
        """Begin to talk with the controller; return what ends it, if anything does.

        Raises:
            DeviceError: It does not answer or refuses.
        """

    def take_right(self) -> PutBack | None:
        """Take the right to switch outputs; return what gives it back, if anything does.

        Raises:
            DeviceError: Somebody else has it.
        """

    def let_go(self) -> bool:
        """Let the arm go where that needs no bringing up; return whether that was so.

        Raises:
            DeviceError: The controller does not answer.
        """

    def require_place(self) -> None:
        """Return if the controller knows where the arm stands.

        Raises:
            DeviceError: It does not: it was restarted.
        """

    def opening_moves(self) -> str:
        """Return what bringing the arm up will move, as a sentence; empty for nothing.

        Raises:
            DeviceError: The controller does not answer.
        """


class ReachMelfa:
    """Reaches a Mitsubishi controller: sessions, and a right that one client has."""

    closed_words = "the servos are off"
    keeps_servos = True

    def __init__(self, arm: MelfaArm, profile: MelfaProfile) -> None:
        self._arm = arm
        self._profile = profile

    def reach(self) -> PutBack | None:
        """Open a session; servos and alarms stay as they are."""
        self._arm.panel.open_session(_CLIENT)
        return self._arm.panel.close_session

    def take_right(self) -> PutBack | None:
        """Take the operation right."""
        panel = self._arm.panel
        panel.take_right()
        panel.reset_program()
        panel.load_program(ArmSettings.from_profile(self._profile).program)
        return panel.give_right_back

    def let_go(self) -> bool:
        """Say no: it is brought up and closed."""
        return False

    def require_place(self) -> None:
        """Return: its encoders are absolute."""

    def opening_moves(self) -> str:
        """Return nothing: switching servos on moves nothing."""
        return ""


class ReachPlain:
    """Reaches an arm whose controller answers anybody at once."""

    closed_words = "disabled in the profile"
    keeps_servos = True

    def reach(self) -> PutBack | None:
        """Do nothing."""
        return None

    def take_right(self) -> PutBack | None:
        """Do nothing: nobody has a right of his own."""
        return None

    def let_go(self) -> bool:
        """Say no: it is closed like any arm."""
        return False

    def require_place(self) -> None:
        """Return."""

    def opening_moves(self) -> str:
        """Return nothing."""
        return ""


class ReachIbm7545(ReachPlain):
    """Reaches the registers of an IBM 7545."""

    closed_words = "no motor has torque; friction holds the arm"
    keeps_servos = False

    def __init__(self, arm: Ibm7545Arm) -> None:
        self._arm = arm

    def let_go(self) -> bool:
        """Take all torque away."""
        self._arm.stop()
        return True

    def require_place(self) -> None:
        """Return if home was found since the slave's power-up."""
        if not self._arm.knows_position():
            raise DeviceRestarted(
                "arm",
                "home was not found since the controller's power-up, so nobody knows where it is",
                hint="see that the way home is free, then `cell robot open` finds it",
            )

    def opening_moves(self) -> str:
        """Return that home will be looked for, if it will."""
        if self._arm.knows_position():
            return ""
        return "the arm looks for its home now: the slide goes up, then joints 1, 2 and 4 turn"


class ReachLynx(ReachPlain):
    """Reaches the servo controller of a Lynx."""

    closed_words = (
        "the arm stands; its servos go on holding it, and only their supply's switch lets it go: "
        "support it first"
    )
    keeps_servos = False

    def __init__(self, arm: Ssc32Arm) -> None:
        self._arm = arm

    def let_go(self) -> bool:
        """Stop the arm where it is; nothing can switch its servos off."""
        self._arm.stop()
        return True

    def require_place(self) -> None:
        """Return: reading the joints says it when the controller was restarted."""

    def opening_moves(self) -> str:
        """Return that the joints will jump to the first pose, if they will."""
        return self._arm.first_pose_needed()


def reaching(arm: ArmSignals, profile: object) -> Reaching:
    """Return how an arm is reached; a disabled one, too."""
    if isinstance(arm, MelfaArm) and isinstance(profile, MelfaProfile):
        return ReachMelfa(arm, profile)
    if isinstance(arm, Ibm7545Arm):
        return ReachIbm7545(arm)
    if isinstance(arm, Ssc32Arm):
        return ReachLynx(arm)
    return ReachPlain()
