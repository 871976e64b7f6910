"""`cell gripper`: the gripper by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter, validators

from console.exits import Exit
from console.figures import Figure
from console.hand import DEFAULTS, HandOptions, as_lines, by_hand, gripper_line, tell
from console.output import say

if TYPE_CHECKING:
    from cell.by_hand import ByHand
    from cell.devices.gripper import GripperState

app = App(name="gripper")


@app.command(name="open")
def open_gripper(*, options: HandOptions = DEFAULTS) -> int:
    """Bring the gripper up: power on, errors cleared, zero found, lights on; leave it so.

    A gripper that does not know its zero looks for it: its fingers move.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        say("bringing the gripper up; the fingers may move ...")
        identity = hands.bring_up_gripper(leave_on=True)
        if hands.has_playground:
            hands.playground.switch_lights(is_on=True)
        now = hands.gripper.read_state()
        told = {"identity": identity, **_facts(now)}
        tell(told, f"{identity}\n{as_lines(_facts(now))}", options)

    return by_hand(options, work)


@app.command(name="close")
def close_gripper(*, options: HandOptions = DEFAULTS) -> int:
    """Stop the fingers and switch the gripper's power off; it keeps what it holds.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        if not hands.has_playground:
            hands.bring_up_gripper(may_move=False)
            text = "the fingers stand still; nothing switches their power"
            tell({"stopped": True}, text, options)
            return
        cell = hands.playground
        hands.take_right()
        bit = cell.profile.outputs.gripper_power
        if cell.arm.arm.read_output(bit):
            hands.bring_up_gripper(may_move=False)
            cell.gripper.close()
            cell.set_output(bit, is_on=False)
        tell({"power": False}, "the gripper's power is off", options)

    return by_hand(options, work)


@app.command
def move(opening_mm: Figure, /, *, options: HandOptions = DEFAULTS) -> int:
    """Move the fingers to an opening.

    Args:
        opening_mm: Opening between the fingers.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.bring_up_gripper()
        say("moving ...")
        hands.gripper.move_to(opening_mm)
        now = hands.gripper.read_state()
        tell(_facts(now), f"open {now.position_mm:.2f} mm", options)

    return by_hand(options, work)


@app.command
def grip(
    *,
    current: Annotated[
        float | None, Parameter(help="Motor current that sets the force, A; the profile's.")
    ] = None,
    options: HandOptions = DEFAULTS,
) -> int:
    """Close the fingers until something holds them; exit code 1 if nothing does.

    Args:
        current: Motor current that sets the force, A; the profile's unless given.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> int:
        # What is gripped shall stay gripped when the command is over.
        hands.bring_up_gripper(leave_on=True)
        say("closing ...")
        result = hands.gripper.grip(hands.grip_current_a() if current is None else current)
        if not hands.has_playground:
            blind: dict[str, object] = {"holding": None, "width_mm": None}
            text = "the fingers closed; nothing measures whether they hold something: look"
            tell(blind, text, options)
            return Exit.DONE
        told: dict[str, object] = {"holding": result.is_holding, "width_mm": result.width_mm}
        holds = f"holds something {result.width_mm:.2f} mm wide"
        tell(told, holds if result.is_holding else "holds nothing", options)
        return Exit.DONE if result.is_holding else Exit.FAILED

    return by_hand(options, work)


@app.command
def wait(
    opening_mm: Figure | None = None,
    /,
    *,
    timeout: Annotated[
        float, Parameter(validator=validators.Number(gt=0), help="How long to wait, s.")
    ] = 10.0,
    options: HandOptions = DEFAULTS,
) -> int:
    """Wait until the fingers stand still, or stand at an opening.

    Args:
        opening_mm: Opening to wait for; standstill unless given.
        timeout: How long to wait, s.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.bring_up_gripper(may_move=False)
        gripper = hands.gripper
        if opening_mm is None:
            gripper.wait_for_stop(timeout)
        else:
            gripper.wait_for_position(opening_mm, timeout)
        now = gripper.read_state()
        tell(_facts(now), f"open {now.position_mm:.2f} mm", options)

    return by_hand(options, work)


@app.command
def stop(*, options: HandOptions = DEFAULTS) -> int:
    """Stop the fingers now.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.bring_up_gripper(may_move=False)
        hands.gripper.stop()
        tell({"stopped": True}, "the fingers stand still", options)

    return by_hand(options, work)


@app.command
def state(*, options: HandOptions = DEFAULTS) -> int:
    """Tell opening, speed, current, flags and error; nothing moves, no servo is switched.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.bring_up_gripper(may_move=False)
        now = hands.gripper.read_state()
        tell(_facts(now), as_lines(_facts(now)), options)

    return by_hand(options, work)


@app.command
def ack(*, options: HandOptions = DEFAULTS) -> int:
    """Acknowledge the gripper's latched errors.

    Args:
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> None:
        hands.bring_up_gripper(may_move=False)
        hands.gripper.acknowledge()
        now = hands.gripper.read_state()
        tell(_facts(now), "no error" if not now.has_error else now.error_text, options)

    return by_hand(options, work)


@app.command(name="list")
def list_grippers(
    *,
    upto: Annotated[
        int, Parameter(validator=validators.Number(gte=1, lte=255), help="Last number to ask.")
    ] = 32,
    options: HandOptions = DEFAULTS,
) -> int:
    """List the modules that answer on the gripper's line.

    Args:
        upto: Last number to ask; they begin with 1.
        options: Options of every command by hand.
    """

    def work(hands: ByHand) -> int:
        say(f"asking the numbers 1 to {upto} ...")
        found = hands.modules(range(1, upto + 1), lambda: gripper_line(hands.playground))
        rows: list[dict[str, object]] = [
            {"number": m.module_id, "kind": m.kind, "firmware": m.firmware} for m in found
        ]
        text = "\n".join(f"{m.module_id}  {m.kind}  firmware {m.firmware}" for m in found)
        tell({"modules": rows}, text or "no module answers", options)
        return Exit.DONE if found else Exit.FAILED

    return by_hand(options, work)


def _facts(now: GripperState) -> dict[str, object]:
    return {
        "position_mm": now.position_mm,
        "velocity_mm_s": now.velocity_mm_s,
        "current_a": now.current_a,
        "referenced": now.is_referenced,
        "moving": now.is_moving,
        "error": now.error,
        "error_text": now.error_text,
    }
