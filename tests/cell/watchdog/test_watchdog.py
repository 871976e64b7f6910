from __future__ import annotations

import json
import random
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cell.errors import CellError, DeviceError
from cell.events import ComponentTested
from cell.profile import Profile, load_profile
from cell.twin.cameras.rendering import Renderer, Shot
from cell.twin.scene import Scene
from cell.twin.wire_faults import WireFault
from cell.watchdog import Outbox, WatchdogThread
from cell.watchdog.report import cause_of
from cell.watchdog.reporters.file import ReportFile
from cell.watchdog.stored import read_report
from tests.cell.watchdog.bugzilla import BugzillaStandIn, Mood
from tests.cell.watchdog.rig import Rig, bugzilla_at

COMPONENTS = (
    "arm", "gripper", "display", "lights", "camera oblique", "camera top", "camera gripper",
)  # fmt: skip


def one_camera() -> Profile:
    """The mash cell with one camera: rendering is all that a test round takes long for."""
    profile = load_profile("mash")
    return profile.model_copy(update={"cameras": {"top": profile.cameras["top"]}})


def test_a_healthy_cell_passes_every_test_and_is_off_afterwards() -> None:
    rig = Rig()
    events, _ = rig.cell.events.subscribe()
    done = rig.watchdog.run_round()
    assert done is not None
    assert [(r.component, r.outcome) for r in done.records] == [(c, "ok") for c in COMPONENTS]
    told = [e.body for e in events.take() if isinstance(e.body, ComponentTested)]
    assert [body.component for body in told] == list(COMPONENTS)
    assert not rig.cell.display.is_on()
    assert not rig.cell.behind.world.scene().are_lights_on
    assert rig.history.faults() == []


def test_the_arm_goes_where_the_reference_says() -> None:
    rig = Rig(profile=one_camera())
    done = rig.watchdog.run_round(only=["arm"])
    assert done is not None
    assert "(600.00, 0.00, 300.00)" in done.records[0].detail


def test_a_round_is_due_every_two_hours_and_not_before() -> None:
    rig = Rig(profile=one_camera())
    rig.pass_hours(1.9)
    assert rig.history.tests() == []
    rig.pass_hours(8.2)
    assert {record.round for record in rig.history.tests()} == {1, 2, 3, 4, 5}


def test_no_round_runs_while_a_session_has_the_cell_and_one_follows_soon_after() -> None:
    rig = Rig(profile=one_camera())
    rig.is_free = False
    rig.pass_hours(5)
    assert rig.history.tests() == []
    rig.is_free = True
    rig.pass_hours(0.05)
    assert {record.round for record in rig.history.tests()} == {1}


def test_what_needs_a_failed_component_is_not_tested_and_not_reported(tmp_path: Path) -> None:
    rig = Rig(ReportFile(tmp_path / "faults.jsonl"), profile=one_camera())
    rig.cell.behind.wires["arm"].inject(WireFault.SILENT)
    done = rig.watchdog.run_round()
    assert done is not None
    assert {r.component: r.outcome for r in done.records} == {
        "arm": "failed",
        "gripper": "not tested",
        "display": "ok",
        "lights": "not tested",
        "camera top": "ok",
    }
    assert [fault.component for fault in rig.history.faults()] == ["arm"]


def test_a_lamp_that_stays_dark_is_noticed_though_its_output_is_on() -> None:
    rig = Rig(profile=one_camera())
    rig.cell.world.burn_out_lamps()
    done = rig.watchdog.run_round(only=["lights"])
    assert done is not None
    record = done.records[-1]
    assert record.outcome == "failed"
    assert "output 8 is on, but the picture stays dark" in record.detail
    assert len(rig.history.faults()) == 1


def test_a_lasting_fault_is_one_fault_and_one_report(tmp_path: Path) -> None:
    path = tmp_path / "faults.jsonl"
    rig = Rig(ReportFile(path), profile=one_camera())
    rig.cell.behind.wires["display"].inject(WireFault.UNPLUGGED)
    rig.pass_hours(24.1)
    assert len(path.read_text().splitlines()) == 1
    (fault,) = rig.history.faults()
    assert (fault.component, fault.times, fault.ended) == ("display", 12, "")
    rig.cell.behind.wires["display"].clear()
    rig.pass_hours(2)
    assert rig.history.faults()[0].ended != ""
    rig.cell.behind.wires["display"].inject(WireFault.UNPLUGGED)
    rig.pass_hours(2)
    assert len(path.read_text().splitlines()) == 2


def test_a_report_holds_the_wire_the_picture_and_the_versions(tmp_path: Path) -> None:
    path = tmp_path / "faults.jsonl"
    rig = Rig(ReportFile(path), profile=one_camera())
    rig.cell.behind.controller.press_emergency_stop(rig.clock.now_s())
    rig.watchdog.run_round()
    rig.outbox.deliver()
    report = json.loads(path.read_text())
    assert "emergency stop" in report["summary"]
    assert "robocell 0.1" in report["description"]
    folder = tmp_path / "faults-files" / report["alias"]
    wire = (folder / "wire.txt").read_text()
    assert "arm      > " in wire
    assert "OPEN=" in wire
    assert report["attachments"] == ["wire.txt"]


@pytest.mark.parametrize("mood", ["refuses", "overloaded", "drops", "deaf after filing", "garbage"])
def test_nothing_is_lost_and_nothing_doubled_while_the_tracker_is_down(mood: Mood) -> None:
    with BugzillaStandIn() as bugzilla:
        rig = Rig(bugzilla_at(bugzilla), profile=one_camera())
        rig.cell.behind.wires["display"].inject(WireFault.SILENT)
        bugzilla.mood = mood
        rig.pass_hours(30)
        tried = bugzilla.requests
        bugzilla.mood = "up"
        rig.pass_hours(7)
        assert len(bugzilla.bugs) == 1
        assert {str(a["file_name"]) for a in bugzilla.bugs[0].attachments} == {"wire.txt"}
        assert len(bugzilla.bugs[0].attachments) == 1
        (sent,) = rig.outbox.waiting()
        assert sent.is_done
        assert sent.reference == "17"
        assert tried <= 80  # An hour at most between attempts: 28 of them, of up to 2 requests.


def test_a_tracker_that_does_not_listen_at_all_is_waited_for() -> None:
    bugzilla = BugzillaStandIn()
    rig = Rig(bugzilla_at(bugzilla), profile=one_camera())
    bugzilla.close()
    rig.cell.behind.wires["display"].inject(WireFault.SILENT)
    rig.pass_hours(4)
    (waiting,) = rig.outbox.waiting()
    assert not waiting.is_done
    assert "does not answer" in waiting.problem


def test_a_wrong_key_or_component_is_said_and_waits_for_new_settings() -> None:
    with BugzillaStandIn() as bugzilla:
        for settings, word in (
            (bugzilla_at(bugzilla, {"ROBOCELL_BUGZILLA_KEY": "wrong"}), "306"),
            (bugzilla_at(bugzilla, {}), "ROBOCELL_BUGZILLA_KEY"),
            (bugzilla_at(bugzilla, component="Nowhere"), "105"),
        ):
            rig = Rig(settings, profile=one_camera())
            rig.cell.behind.wires["display"].inject(WireFault.SILENT)
            before = bugzilla.requests
            rig.pass_hours(5)
            (waiting,) = rig.outbox.waiting()
            assert word in waiting.problem
            assert "wrong" not in waiting.problem
            assert bugzilla.requests - before <= 1


def test_what_waits_for_new_settings_is_sent_at_once_when_asked() -> None:
    with BugzillaStandIn() as bugzilla:
        bugzilla.mood = "overloaded"
        rig = Rig(bugzilla_at(bugzilla), profile=one_camera())
        rig.cell.behind.wires["display"].inject(WireFault.SILENT)
        rig.pass_hours(2.1)
        bugzilla.mood = "up"
        assert rig.outbox.deliver() == 0
        rig.outbox.hurry()
        assert rig.outbox.deliver() == 1


def test_an_old_bugzilla_knows_the_key_as_a_field_only() -> None:
    with BugzillaStandIn(knows_header=False) as bugzilla:
        rig = Rig(bugzilla_at(bugzilla), profile=one_camera())
        rig.cell.behind.wires["display"].inject(WireFault.SILENT)
        rig.pass_hours(2.1)
        assert len(bugzilla.bugs) == 1


def test_an_answer_that_trickles_in_is_given_up_at_the_deadline() -> None:
    with BugzillaStandIn() as bugzilla:
        bugzilla.mood = "trickles"
        rig = Rig(bugzilla_at(bugzilla, timeout_s="0.2"), profile=one_camera())
        rig.cell.behind.wires["display"].inject(WireFault.SILENT)
        rig.watchdog.run_round(only=["display"])
        assert rig.outbox.deliver() == 0
        assert "trickles" in rig.outbox.waiting()[0].problem


def test_a_key_never_gets_into_a_message() -> None:
    with BugzillaStandIn() as bugzilla:
        for key in ("SECRET\n", "SEC\nRET"):
            rig = Rig(bugzilla_at(bugzilla, {"ROBOCELL_BUGZILLA_KEY": key}), profile=one_camera())
            rig.cell.behind.wires["display"].inject(WireFault.SILENT)
            rig.watchdog.run_round(only=["display"])
            rig.outbox.deliver()
            problem = rig.outbox.waiting()[0].problem
            assert problem
            assert "SEC" not in problem


def test_half_a_line_left_by_a_crash_loses_no_report(tmp_path: Path) -> None:
    path = tmp_path / "faults.jsonl"
    rig = Rig(ReportFile(path), profile=one_camera())
    rig.cell.behind.wires["display"].inject(WireFault.SILENT)
    rig.watchdog.run_round(only=["display"])
    (stored,) = rig.stored_reports()
    alias = read_report(stored).alias
    path.write_text(f'{{"number": 1, "alias": "{alias}", "summ')
    assert ReportFile(path).file(read_report(stored), may_be_known=True) == alias
    torn, whole = path.read_text().splitlines()
    assert torn.endswith("summ")
    assert json.loads(whole)["alias"] == alias
    assert ReportFile(path).file(read_report(stored), may_be_known=True) == alias
    assert len(path.read_text().splitlines()) == 2


def test_a_report_that_cannot_be_read_holds_no_other_one_back(tmp_path: Path) -> None:
    path = tmp_path / "faults.jsonl"
    rig = Rig(ReportFile(path), profile=one_camera())
    for device in ("display", "gripper"):
        rig.cell.behind.wires[device].inject(WireFault.SILENT)
        rig.watchdog.run_round(only=[device])
    with rig.history.transaction() as database:
        database.execute("UPDATE outgoing SET report = ? WHERE fault = 1", (b"{",))
    assert rig.outbox.deliver() == 1
    assert "cannot be read" in rig.outbox.waiting()[0].problem
    assert "gripper" in path.read_text()


def test_two_processes_send_a_report_once() -> None:
    with BugzillaStandIn() as bugzilla:
        rig = Rig(bugzilla_at(bugzilla), profile=one_camera())
        rig.cell.behind.wires["display"].inject(WireFault.SILENT)
        rig.watchdog.run_round(only=["display"])
        other = Outbox(rig.history, [bugzilla_at(bugzilla)], rig.wall_clock().timestamp)
        taken = rig.outbox._claim(f"bugzilla {bugzilla.url}", 1, 0)
        assert taken
        assert other.deliver() == 0
        assert bugzilla.bugs == []


def test_a_test_alone_comes_with_what_it_needs() -> None:
    rig = Rig(profile=one_camera())
    rig.cell.behind.wires["arm"].inject(WireFault.SILENT)
    done = rig.watchdog.run_round(only=["gripper"])
    assert done is not None
    assert [(r.component, r.outcome) for r in done.records] == [
        ("arm", "failed"),
        ("gripper", "not tested"),
    ]


def test_a_television_that_was_on_is_on_after_its_test() -> None:
    rig = Rig(profile=one_camera())
    rig.cell.display.open()
    rig.cell.display.switch_on()
    rig.cell.display.close()
    rig.watchdog.run_round(only=["display"])
    rig.cell.display.open()
    assert rig.cell.display.is_on()


def test_reports_wait_through_a_restart(tmp_path: Path) -> None:
    path = tmp_path / "watchdog.sqlite"
    with BugzillaStandIn() as bugzilla:
        bugzilla.mood = "overloaded"
        rig = Rig(bugzilla_at(bugzilla), path=path, profile=one_camera())
        rig.cell.behind.wires["display"].inject(WireFault.SILENT)
        rig.pass_hours(3)
        rig.history.close()
        bugzilla.mood = "up"
        again = Rig(bugzilla_at(bugzilla), path=path, profile=one_camera())
        again.cell.behind.wires["display"].inject(WireFault.SILENT)
        again.pass_hours(7)
        assert len(bugzilla.bugs) == 1
        assert again.outbox.waiting()[0].is_done


def test_the_history_forgets_rounds_but_no_fault() -> None:
    profile = one_camera()
    short = profile.watchdog.model_copy(update={"keep": 3})
    rig = Rig(profile=profile.model_copy(update={"watchdog": short}))
    rig.cell.behind.wires["display"].inject(WireFault.LOST)
    for _ in range(6):
        rig.watchdog.run_round(only=["display"])
    assert {record.round for record in rig.history.tests(100)} == {4, 5, 6}


def test_figures_do_not_make_another_cause_but_a_device_number_does() -> None:
    def cause(problem: str, code: int | None = None) -> str:
        return cause_of("arm", DeviceError("arm", problem, code=code))

    assert cause("stood at 12.3 mm") == cause("stood at -45 mm")
    assert cause("an alarm", 2602) != cause("an alarm", 2603)
    assert cause("fell silent") != cause("answered garbage")


def test_the_thread_tests_and_stops() -> None:
    rig = Rig(profile=one_camera())
    thread = WatchdogThread(rig.watchdog)
    rig.clock.sleep(7200.0)
    tested, unsubscribe = rig.cell.events.subscribe()
    thread.start()
    assert thread.stop()
    unsubscribe()
    assert len([e for e in tested.take() if isinstance(e.body, ComponentTested)]) <= 5


def test_the_thread_outlives_what_nobody_foresaw(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    rig = Rig(profile=one_camera())
    came = threading.Event()

    def step() -> float:
        came.set()
        raise ZeroDivisionError("a mistake of ours")

    monkeypatch.setattr(rig.watchdog, "step", step)
    thread = WatchdogThread(rig.watchdog)
    thread.start()
    assert came.wait(10.0)
    assert thread.stop()
    assert "ZeroDivisionError at test_watchdog.py" in caplog.text
    assert "Traceback" not in caplog.text


def test_an_arm_that_is_held_is_left_alone_until_people_ask_to_go_on() -> None:
    rig = Rig(profile=one_camera())
    rig.cell.open()
    rig.cell.move_to(600.0, 0.0, 300.0)
    _press(rig)
    with pytest.raises(CellError):
        rig.cell.move_to(500.0, 0.0, 300.0)
    _release(rig)
    rig.cell.close()
    before = rig.cell.behind.world.joints_deg(rig.clock.now_s())
    done = rig.watchdog.run_round(only=["arm"])
    assert done is not None
    assert [(r.outcome, "begin a new task" in r.detail) for r in done.records] == [
        ("not tested", True)
    ]
    assert rig.cell.behind.world.joints_deg(rig.clock.now_s()) == before
    rig.cell.arm.allow_resume()
    again = rig.watchdog.run_round(only=["arm"])
    assert again is not None
    assert [r.outcome for r in again.records] == ["ok"]
    assert rig.history.faults() == []


Hand = Callable[[Rig], None]


def _wire(device: str, fault: WireFault) -> tuple[str, Hand, Hand]:
    def begin(rig: Rig) -> None:
        rig.cell.behind.wires[device].inject(fault)

    def end(rig: Rig) -> None:
        rig.cell.behind.wires[device].clear()

    return device, begin, end


def _press(rig: Rig) -> None:
    rig.cell.behind.controller.press_emergency_stop(rig.clock.now_s())


def _release(rig: Rig) -> None:
    rig.cell.behind.controller.release_emergency_stop(rig.clock.now_s())


def _key(*, is_automatic: bool) -> Hand:
    def turn(rig: Rig) -> None:
        rig.cell.behind.controller.set_key_switch(rig.clock.now_s(), is_automatic=is_automatic)

    return turn


def _panel(*, is_held: bool) -> Hand:
    def hold(rig: Rig) -> None:
        rig.cell.behind.controller.hold_right_by_panel(rig.clock.now_s(), is_held=is_held)

    return hold


def _pull(rig: Rig) -> None:
    rig.cell.behind.cameras["top"].pull_cable()


def _plug(rig: Rig) -> None:
    rig.cell.behind.cameras["top"].plug_in()


def _mute(*, is_silent: bool) -> Hand:
    def turn(rig: Rig) -> None:
        rig.cell.behind.cameras["top"].fall_silent(is_silent)

    return turn


def _sketched(renderer: Renderer, scene: Scene, shot: Shot) -> NDArray[np.uint8]:
    """Stand in for the renderer, which five hundred rounds would spend nearly all their time in.

    Light, dark and two greys are all that the watchdog looks at.
    """
    pixels = np.full((960, 1280, 3), 120 if scene.are_lights_on else 10, np.uint8)
    pixels[: shot.number % 900 + 1] //= 2
    return pixels


FAULTS: tuple[tuple[str, Hand, Hand], ...] = (
    _wire("arm", WireFault.SILENT),
    _wire("arm", WireFault.UNPLUGGED),
    ("arm", _press, _release),
    ("arm", _key(is_automatic=False), _key(is_automatic=True)),
    ("arm", _panel(is_held=True), _panel(is_held=False)),
    _wire("gripper", WireFault.SILENT),
    _wire("gripper", WireFault.UNPLUGGED),
    _wire("display", WireFault.SILENT),
    _wire("display", WireFault.UNPLUGGED),
    ("camera top", _pull, _plug),
    ("camera top", _mute(is_silent=True), _mute(is_silent=False)),
)


@pytest.mark.timeout(600)
def test_500_rounds_with_faults_report_each_fault_once_to_a_tracker_that_goes_down(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Renderer, "take", _sketched)
    seed = 20260105
    source = random.Random(seed)
    moods: tuple[Mood, ...] = ("overloaded", "drops", "deaf after filing", "refuses", "garbage")
    seeded: list[str] = []
    with BugzillaStandIn() as bugzilla:
        rig = Rig(bugzilla_at(bugzilla), profile=one_camera(), seed=seed)
        ending: list[tuple[int, Hand]] = []
        for number in range(500):
            # A fault begins when the cell has been whole for a round, so that it is a new one.
            was_whole = not ending
            for due, end in [e for e in ending if e[0] == number]:
                end(rig)
                ending.remove((due, end))
            if was_whole and source.random() < 0.05:
                component, begin, end = source.choice(FAULTS)
                begin(rig)
                seeded.append(component)
                ending.append((number + source.randint(1, 4), end))
            bugzilla.mood = source.choice(moods) if source.random() < 0.4 else "up"
            rig.pass_hours(2)
        for _, end in ending:
            end(rig)
        bugzilla.mood = "up"
        rig.pass_hours(8)
        assert len(seeded) >= 10, f"seed {seed}"
        assert [fault.component for fault in rig.history.faults()] == seeded, f"seed {seed}"
        assert len(bugzilla.bugs) == len(seeded), f"seed {seed}"
        filed = [str(bug.fields["summary"]).split(": ")[1] for bug in bugzilla.bugs]
        assert filed == seeded, f"seed {seed}"
        # A cable that is out carries nothing, so such a fault has no capture.
        expected = [
            [a.name for a in read_report(stored).attachments] for stored in rig.stored_reports()
        ]
        assert [[a["file_name"] for a in bug.attachments] for bug in bugzilla.bugs] == expected, (
            f"seed {seed}"
        )
        assert sum(map(len, expected)) >= len(seeded) // 2
        assert all(sent.is_done for sent in rig.outbox.waiting()), f"seed {seed}"
        rounds = {record.round for record in rig.history.tests(1000)}
        assert len(rounds) >= 500, f"seed {seed}"
