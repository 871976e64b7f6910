"""`cell robot`: the arm by hand, every motion through the guard."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from console.exits import ConsoleError
from console.figures import Figure, Whole
from console.hand import DEFAULTS, HandOptions, as_lines, by_hand, tell
from console.hand_speed import keep_speed, kept_speed
from console.output import put, put_json, say

if TYPE_CHECKING:
    from cell.by_hand import ByHand
    from cell.geometry import JointPositions, Pose

app = App(name="robot")

_AXIS = re.compile(r"[xyz]|j[1-9]", re.IGNORECASE)
Rotation = Annotated[Figure, Parameter(help="Turn of the gripper about the vertical, deg.")]


@app.command(name="open")
def open_arm(
    *,
    keep: Annotated[bool, Parameter(negative="", help="Leave the servos on.")] = False,
    first_pose: Annotated[
        bool,
        Parameter(
            negative="", help="The arm stands in its rest pose, put there by hand; stand clear."
        ),
    ] = False,
    options: HandOptions = DEFAULTS,
) -> int:
    """Bring the arm up: alarms cleared, servos on; tell who it is and where it stands.

    An arm that was just powered may have to move for that: it finds its home, or jumps to its
    first pose. What it does is told before.

    Args:
        keep: Whether the servos stay on when the command ends.
        first_pose: Whether an arm of servos was put into its rest pose by hand.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        say("bringing the arm up ...")
        identity = bring_up(hands, leave_on=keep, is_confirmed=first_pose)
        pose = hands.pose()
        stays = keep and hands.reaching.keeps_servos
        if options.as_json:
            put_json({"identity": identity, "pose": _pose_json(pose), "servos_stay_on": stays})
            return
        put(f"{identity}\nat {pose}")
        if not hands.reaching.keeps_servos:
            say(hands.reaching.closed_words)
        else:
            say("the servos stay on" if keep else "the servos go off again (--keep leaves them on)")

    return by_hand(options, work)


@app.command(name="close")
def close_arm(*, options: HandOptions = DEFAULTS) -> int:
    """Stop the arm, switch its servos off where they can be, and give control back.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.let_go()
        tell({"closed": True}, hands.reaching.closed_words, options)

    return by_hand(options, work)


@app.command
def pose(*, options: HandOptions = DEFAULTS) -> int:
    """Tell where the tool point is.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        here = hands.pose()
        tell(_pose_json(here), str(here), options)

    return by_hand(options, work)


@app.command
def joints(
    *values: Annotated[Figure, Parameter(help="Where each joint shall go, J1 first.")],
    options: HandOptions = DEFAULTS,
) -> int:
    """Tell where the joints are; with a value for each, move them there.

    Args:
        values: Where each joint shall go, deg (mm for one that slides); J1 first.
        options: Options of every command by hand.
    """
    from cell.geometry import JointPositions

    def work(hands: ByHand) -> None:
        if values:
            _require_joints(len(values), hands)
            _motion(hands, options, lambda: hands.cell.arm.move_joints(JointPositions(values)))
            return
        here = hands.joints()
        tell(_joints_json(here), _joints_text(here), options)

    return by_hand(options, work)


@app.command
def move(
    x_mm: Figure,
    y_mm: Figure,
    z_mm: Figure | None = None,
    /,
    *,
    rotation: Rotation | None = None,
    options: HandOptions = DEFAULTS,
) -> int:
    """Move the tool point, gripper down, to a place in the robot frame.

    Over a playground in a straight line at the same height; otherwise up to the service height,
    over, and down. Elsewhere in a straight line, or with all joints at once where it is not free.

    Args:
        x_mm: Robot x.
        y_mm: Robot y.
        z_mm: Height above the robot's base plane; 200, without a playground as it stands.
        rotation: Turn of the gripper about the vertical, deg; 180, without a playground as it is.
        options: Options of every command by hand.
    """
    return by_hand(
        options,
        lambda hands: _motion(hands, options, lambda: hands.move_to(x_mm, y_mm, z_mm, rotation)),
    )


@app.command
def lattice(
    x: Whole,
    y: Whole,
    /,
    *,
    height: Annotated[Figure, Parameter(help="Height of the tool point, mm.")] = 200.0,
    rotation: Rotation = 180.0,
    options: HandOptions = DEFAULTS,
) -> int:
    """Move the tool point over a point of the lattice.

    Args:
        x: Lattice x.
        y: Lattice y.
        height: Height of the tool point above the robot's base plane, mm.
        rotation: Turn of the gripper about the vertical, deg.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        cell = hands.playground
        _motion(hands, options, lambda: cell.move_to_lattice(x, y, height, rotation))

    return by_hand(options, work)


@app.command
def jog(
    axis: str, step: Figure, /, *,
    options: HandOptions = DEFAULTS,
) -> int:  # fmt: skip
    """Move a little along x, y or z (mm, a straight line), or one joint (j1 to j6, deg).

    Args:
        axis: x, y, z, or j1, j2, ...
        step: How far, mm or deg; less than 0 for the other way.
        options: Options of every command by hand.
    """
    if not _AXIS.fullmatch(axis):
        raise ConsoleError(f"{axis!r} is no axis; x, y, z and j1, j2, ... are")

    def work(hands: ByHand) -> None:
        if axis.lower().startswith("j"):
            number = int(axis[1:])
            _motion(hands, options, lambda: _jog_joint(hands, number, step))
        else:
            _motion(hands, options, lambda: _jog_line(hands, axis.lower(), step))

    return by_hand(options, work)


@app.command
def speed(
    speed_mm_s: Figure | None = None,
    joint_percent: Figure | None = None,
    /,
    *,
    options: HandOptions = DEFAULTS,
) -> int:
    """Tell the speed of moves by hand, or set it for all later ones.

    Args:
        speed_mm_s: Speed of the tool point along lines.
        joint_percent: Share of full speed in joint moves; as before unless given.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        line, share = kept_speed(hands.cell.profile)
        if speed_mm_s is not None:
            line, share = speed_mm_s, joint_percent if joint_percent is not None else share
            if hands.has_playground:
                hands.bring_up_arm()
            hands.cell.arm.set_speed(line, share)
            keep_speed(hands.cell.profile, line, share)
        tell(
            {"speed_mm_s": line, "joint_percent": share},
            f"{line:g} mm/s along lines, {share:g} % of full speed in joint moves",
            options,
        )

    return by_hand(options, work)


@app.command
def rest(*, options: HandOptions = DEFAULTS) -> int:
    """Stand aside, out of every camera's way, all joints at once.

    Args:
        options: Options of every command by hand.
    """
    return by_hand(options, lambda hands: _motion(hands, options, hands.cell.arm.rest))


@app.command
def home(*, options: HandOptions = DEFAULTS) -> int:
    """Go straight up to the service height first, then stand aside.

    Args:
        options: Options of every command by hand.
    """
    return by_hand(options, lambda hands: _motion(hands, options, hands.home))


@app.command
def alarm(
    *,
    reset: Annotated[
        bool, Parameter(negative="", help="Clear an alarm whose cause is gone.")
    ] = False,
    options: HandOptions = DEFAULTS,
) -> int:
    """Tell the active alarm, or clear it.

    Args:
        reset: Whether it is cleared.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.reach_controller()
        if reset:
            hands.cell.arm.arm.reset_alarm()
        state = hands.cell.arm.arm.read_state()
        text = f"alarm {state.alarm}: {state.alarm_text}" if state.alarm else "no alarm"
        tell({"alarm": state.alarm, "text": state.alarm_text}, text, options)

    return by_hand(options, work)


@app.command
def stop(*, options: HandOptions = DEFAULTS) -> int:
    """Stop any motion of the arm now.

    It does not replace the emergency stop: the controller must hear it.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.reach_controller()
        hands.cell.arm.arm.stop()
        tell({"stopped": True}, "the arm stands still", options)

    return by_hand(options, work)


@app.command
def state(*, options: HandOptions = DEFAULTS) -> int:
    """Tell the controller's state: servos, motion, key switch, emergency stop, alarm.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.reach_controller()
        now = hands.cell.arm.arm.read_state()
        told: dict[str, object] = {
            "servos_on": now.is_servo_on,
            "moving": now.is_moving,
            "automatic": now.is_automatic,
            "emergency_stop": now.is_emergency_stopped,
            "alarm": now.alarm,
            "alarm_text": now.alarm_text,
            "override_percent": now.override_percent,
        }
        tell(told, as_lines(told), options)

    return by_hand(options, work)


@app.command
def magnet(switch: Literal["on", "off"], /, *, options: HandOptions = DEFAULTS) -> int:
    """Switch the electromagnet (tool 2).

    Args:
        switch: on or off.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        cell = hands.playground
        hands.take_right()
        cell.switch_magnet(is_on=switch == "on")
        tell({"magnet": switch}, f"the magnet is {switch}", options)

    return by_hand(options, work)


def bring_up(hands: ByHand, *, leave_on: bool = False, is_confirmed: bool = False) -> str:
    """Bring the arm up; tell first what moves, and have it confirmed where the profile says so.

    Raises:
        ConsoleError: Nobody confirms that the arm was put into its rest pose.
    """
    moves = hands.opening_moves()
    if moves:
        say(moves, "yellow")
        if is_confirmed or (hands.needs_confirmation and _confirms()):
            hands.confirm_first_pose()
        elif hands.needs_confirmation:
            raise ConsoleError(
                "the first pose is not confirmed, and nothing moved: put the arm into its rest "
                "pose by hand, stand clear, then `cell robot open --first-pose`"
            )
    return hands.bring_up_arm(leave_on=leave_on)


def _confirms() -> bool:
    """Ask somebody at a terminal whether the arm may jump to its rest pose."""
    if not sys.stdin.isatty():
        return False
    say("Put the arm into its rest pose by hand, stand clear, keep a hand at the servo supply.")
    say("Is it there, and may it move? [y/N]")
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _motion(hands: ByHand, options: HandOptions, go: Callable[[], None]) -> None:
    """Bring the arm up, let it go, and tell where it stands then."""
    bring_up(hands)
    hands.cell.arm.set_speed(*kept_speed(hands.cell.profile))
    say("moving ...")
    go()
    arm = hands.cell.arm
    here, stand = arm.pose(), arm.joints()
    tell({**_pose_json(here), **_joints_json(stand)}, f"at {here}", options)


def _jog_line(hands: ByHand, axis: str, step_mm: float) -> None:
    from dataclasses import replace

    here = hands.cell.arm.pose()
    moved = {
        "x": replace(here, x_mm=here.x_mm + step_mm),
        "y": replace(here, y_mm=here.y_mm + step_mm),
        "z": replace(here, z_mm=here.z_mm + step_mm),
    }
    hands.cell.arm.move_linear(moved[axis])


def _jog_joint(hands: ByHand, number: int, step: float) -> None:
    from cell.geometry import JointPositions

    here = hands.cell.arm.joints().values
    if not 1 <= number <= len(here):
        raise ConsoleError(f"j{number}: the arm has j1 to j{len(here)}")
    hands.cell.arm.move_joints(
        JointPositions(tuple(v + step * (i == number) for i, v in enumerate(here, 1)))
    )


def _require_joints(given: int, hands: ByHand) -> None:
    wanted = len(hands.cell.profile.arm.rest_deg)
    if given != wanted:
        raise ConsoleError(f"{given} values are given; the arm has {wanted} joints")


def _pose_json(pose: Pose) -> dict[str, object]:
    figures = {
        "x_mm": pose.x_mm, "y_mm": pose.y_mm, "z_mm": pose.z_mm,
        "a_deg": pose.a_deg, "b_deg": pose.b_deg, "c_deg": pose.c_deg,
    }  # fmt: skip
    return {name: _rounded(value) for name, value in figures.items()}


def _joints_json(joints: JointPositions) -> dict[str, object]:
    return {f"j{number}": _rounded(value) for number, value in enumerate(joints.values, 1)}


def _rounded(value: float) -> float:
    return round(value, 4) + 0.0  # Not -0.0.


def _joints_text(joints: JointPositions) -> str:
    return "  ".join(f"J{number} {value:.2f}" for number, value in enumerate(joints.values, 1))
