"""The steps on the twin: each sees what the doctor sees, and the devices open with one report."""

from __future__ import annotations

from pathlib import Path

from cell.bringup import BringUp, BringUpReport, Looked, bring_up_steps, connect_devices
from cell.doctor import Component, PortState, Report
from cell.twin.wire_faults import WireFault
from tests.cell.doctor.ward import Ward, mash, twin


def play(ward: Ward) -> BringUpReport:
    dispose = ward.cell.dispose
    ward.cell.dispose = lambda: None  # type: ignore[method-assign]

    def examine(component: Component) -> Report:
        return ward.examine(component)

    steps = bring_up_steps(
        ward.profile, examine, lambda: connect_devices(ward.cell, in_parallel=False)
    )
    course = BringUp(steps)
    while course.current is not None:
        if course.look().outcome != "done":
            course.give_up()
    dispose()
    return course.report()


def missing(ward: Ward) -> dict[str, str]:
    return {one.step: one.link.partition("#")[2] for one in play(ward).missing}


def test_a_healthy_twin_is_ready_without_a_question() -> None:
    report = play(Ward().with_pictures())
    assert report.is_ready, report.missing
    assert all(one.evidence for one in report.results)


def test_the_guides_six_steps_are_there_in_their_order() -> None:
    steps = bring_up_steps(mash(), _no_report, tuple)
    assert [step.guide for step in steps if step.guide] == [1, 2, 3, 4, 5, 6]
    assert len({step.id for step in steps}) == len(steps)


def test_the_key_at_teach_keeps_the_controller_from_being_ready() -> None:
    ward = Ward().with_pictures()
    ward.cell.behind.controller.set_key_switch(ward.now_s, is_automatic=False)
    found = missing(ward)
    assert found["controller"] == "arm-key-at-teach"
    assert "television" not in found
    assert "connect" in found


def test_a_board_without_power_is_asked_about() -> None:
    ward = Ward().with_pictures()
    ward.cell.behind.wires["arm"].inject(WireFault.SILENT)
    report = play(ward)
    board = next(one for one in report.results if one.step == "board")
    assert board.outcome == "open"
    assert "lamp" in board.fix


def test_left_blocks_and_a_taken_port_are_missing_steps() -> None:
    ward = Ward().with_pictures()
    ward.cell.ledger.plan(7, None, None)
    ward.surroundings.port = PortState(is_free=False, seen="in use")
    found = missing(ward)
    assert found == {"leftovers": "transfer-interrupted", "server": "server-port-taken"}


def test_one_report_tells_of_every_device_that_does_not_open() -> None:
    cell = twin(mash())
    for wire in cell.behind.wires.values():
        wire.inject(WireFault.UNPLUGGED)
    cell.behind.cameras["top"].pull_cable()
    connected = connect_devices(cell, in_parallel=False)
    failed = {one.device for one in connected if one.problem}
    assert failed == {"arm", "gripper", "display", "camera top"}
    assert {one.device for one in connected if one.identity} == {"camera oblique", "camera gripper"}
    cell.dispose()


def test_devices_are_closed_again_after_they_were_opened() -> None:
    cell = twin(mash())
    connected = connect_devices(cell, in_parallel=False)
    assert not [one for one in connected if one.problem]
    assert not cell.behind.television.is_on
    assert not any(cell.world.outputs.values())
    assert cell.behind.controller._commands.state.holder == "nobody"
    cell.dispose()


def test_a_disabled_device_has_no_step(tmp_path: Path) -> None:
    gripper = mash().gripper.model_copy(update={"enabled": False})
    profile = mash().model_copy(update={"gripper": gripper})
    steps = bring_up_steps(profile, _no_report, tuple)
    assert "gripper" not in {step.id for step in steps}


def test_a_step_that_nothing_was_measured_of_cannot_tell() -> None:
    steps = {step.id: step for step in bring_up_steps(mash(), _no_report, tuple)}
    looked = steps["gripper"].look()
    assert isinstance(looked, Looked)
    assert looked.verdict == "cannot tell"


def _no_report(component: Component) -> Report:
    return Report(findings=(), fine=(), unchecked=())
