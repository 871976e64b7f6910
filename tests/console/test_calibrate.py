"""`cell calibrate` and `cell calibration`, from the questions to what the cell then knows."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from calibration import catalogue
from calibration.archive import Archive
from calibration.pictures import decode_png
from cell.ledger import Ledger
from cell.profile import load_profile
from console.asking import TerminalAsker
from dsl.library import library_script
from tests.calibration.sample_procedures import CYLINDER, ENTRIES
from tests.console.cli import environment
from tests.console.hands import Cell, caller

KILLING = """
import os, signal, sys
from tests.calibration.sample_procedures import install
install()
from calibration.hands import CellHands
from calibration.journal import RunJournal
from console.cli import main
count, nth, noted = 0, int(sys.argv[1]), sys.argv[2]
kind = RunJournal if noted == "unnoted" else CellHands
name = "note" if noted == "unnoted" else "perform"
real = getattr(kind, name)
def counted(self, *arguments):
    global count
    count += 1
    if count == nth:
        os.kill(os.getpid(), signal.SIGNAL)
    return real(self, *arguments)
setattr(kind, name, counted)
sys.exit(main(sys.argv[3:]))
"""


@pytest.fixture
def cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Cell:
    monkeypatch.setattr(catalogue, "CATALOGUE", ENTRIES)
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
    return caller(tmp_path, monkeypatch, capsys)


@pytest.fixture
def state(tmp_path: Path) -> Path:
    return tmp_path / "state" / "robocell" / "cells" / "mash"


def child(home: Path, nth: int, noted: str, *words: str, by: str = "SIGKILL") -> int:
    """Run the command line in a process that ends itself before its nth request or note."""
    code = KILLING.replace("SIGNAL", by)
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", code, str(nth), noted, *words],
        env=environment(home), stdin=subprocess.DEVNULL, capture_output=True, text=True,
        timeout=90, check=False,
    )  # fmt: skip
    assert "unexpected" not in run.stderr, run.stderr
    return run.returncode


def test_the_procedures_there_are_are_listed(cell: Cell) -> None:
    assert "Lay a block three times." in cell("calibrate").out
    assert [one["name"] for one in json.loads(cell("calibrate", "--json").out)] == [
        entry.name for entry in ENTRIES
    ]


def test_an_unknown_procedure_is_a_wrong_usage_that_names_the_others(cell: Cell) -> None:
    said = cell("calibrate", "homografy")
    assert said.code == 2
    assert "there are laid, typed" in said.err


def test_what_is_measured_is_kept_with_its_pictures_and_the_block_goes_home(
    cell: Cell, state: Path
) -> None:
    said = cell("calibrate", "laid", "--json")
    assert said.code == 0
    identity = said.data()["identity"]
    archive = Archive(state / "calibrations")
    (record,) = archive.current()
    assert record.identity == identity
    assert record.answers == {"shift": 0.0}
    assert record.cameras == {"top": load_profile("mash").cameras["top"].guid}
    assert record.measured_at.utcoffset() is not None
    for sample in record.samples:
        assert decode_png(archive.picture(sample.picture), "x").shape == (960, 1280, 3)
    assert Ledger(state / "ledger.sqlite").blocks_out() == {}
    assert not (state / "calibration-runs" / "laid").exists()


def test_list_show_diff_and_undo(cell: Cell, tmp_path: Path) -> None:
    assert "cell calibrate" in cell("calibration", "list").err
    for shift in ("0", "2"):
        cell("calibrate", "laid", "--set", f"shift={shift}")
    (listed,) = json.loads(cell("calibration", "list", "--json").out)
    assert (listed["kind"], listed["subject"], listed["accuracy"]) == ("homography", "top", 3.5)
    (before,) = listed["before"]
    shown = cell("calibration", "show", "homography", "--picture", "over.png")
    assert "place 2  given (500.00, 0.00)" in shown.out
    assert "in force, cell mash" in shown.out
    assert decode_png((tmp_path / "over.png").read_bytes(), "x").shape == (994, 1280, 3)
    whole = json.loads(cell("calibration", "show", before[:8], "--json").out)
    assert whole["is_in_force"] is False
    assert len(whole["samples"]) == 3
    found = json.loads(
        cell("calibration", "diff", before[:8], listed["identity"][:8], "--json").out
    )
    assert [round(c["distance_mm"], 1) for c in found["corners"]["top"]] == [2.0] * 4
    assert before[:8] in cell("calibration", "undo", "homography", "top").out
    assert "the profile's own counts" in cell("calibration", "undo", "homography", "top").out
    said = cell("calibration", "undo", "homography", "top")
    assert said.code == 2


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("show", "homography"), "there are none; `cell calibrate` lists"),
        (("show", "abcdef12"), "no calibration begins with abcdef12"),
        (("show", "zzzz"), "no calibration zzzz is in force"),
        (("diff", "abcd", "abce"), "no calibration begins with abcd"),
        (("undo", "lattice", "cell"), "no calibration of lattice cell is in force"),
        (("check", "lattice"), "no lattice of the cell mash is in force"),
    ],
)
def test_what_is_not_there_is_a_wrong_usage_that_says_so(
    cell: Cell, words: tuple[str, ...], told: str
) -> None:
    said = cell("calibration", *words)
    assert said.code == 2
    assert told in said.err


@pytest.mark.parametrize(("moved", "grade", "code"), [("0", "OK", 0), ("1.5", "DEGRADED", 0),
                                                      ("3", "BAD", 1)])  # fmt: skip
def test_a_check_on_a_fresh_picture_tells_whether_it_still_holds(
    cell: Cell, moved: str, grade: str, code: int
) -> None:
    assert cell("calibration", "check").code == 0
    cell("calibrate", "laid")
    cell("calibrate", "typed", "--set", "origin=1 2")
    said = cell("calibration", "check", "--set", f"moved={moved}", "--json")
    assert said.code == code
    assert [one["grade"] for one in json.loads(said.out)] == [grade]
    assert cell("calibration", "check", "lattice").code == 1


def test_all_missing_answers_are_told_at_once_and_nothing_is_waited_for(cell: Cell) -> None:
    said = cell("calibrate", "typed", "--set", "how=guess")
    assert said.code == 2
    assert "how: one of ruler, arm is expected, not 'guess'" in said.err
    assert "origin: no answer is given (a list of 2 numbers in mm)" in said.err


def test_answers_come_from_a_file_and_what_nobody_asked_for_is_told(
    cell: Cell, tmp_path: Path
) -> None:
    (tmp_path / "a.toml").write_text('how = "arm"\norigin = [700, -260]\nheight = 3\n')
    said = cell("calibrate", "typed", "--answers", "a.toml", "--set", "error=0.2", "--json")
    assert said.code == 0
    assert "a.toml:3: nothing asked for 'height'" in said.err
    assert said.data()["method"] == "typed, measured by arm"


def test_a_bad_result_is_kept_to_be_looked_at_and_changes_nothing(cell: Cell) -> None:
    cell("calibrate", "typed", "--set", "origin=700 -260")
    said = cell("calibrate", "typed", "--set", "origin=1 2", "--set", "error=9", "--json")
    assert said.code == 1
    assert "far-off" in said.out
    assert "not put in force" in said.err
    identity = said.data()["identity"]
    assert isinstance(identity, str)
    assert "BAD far-off" in cell("calibration", "show", identity[:8]).out
    (listed,) = json.loads(cell("calibration", "list", "--json").out)
    assert listed["identity"] != identity


def test_a_procedure_that_comes_to_no_end_brings_its_block_home(cell: Cell, state: Path) -> None:
    said = cell("calibrate", "failing")
    assert said.code == 1
    assert "three points on a line" in said.err
    assert Ledger(state / "ledger.sqlite").blocks_out() == {}
    assert "no interrupted run" in cell("calibrate", "failing", "--resume").err


def test_a_copy_can_be_written(cell: Cell, tmp_path: Path) -> None:
    cell("calibrate", "laid", "--out", "copy")
    assert len(list((tmp_path / "copy").glob("*.png"))) == 3
    (copied,) = (tmp_path / "copy").glob("homography-top-*.json")
    assert json.loads(copied.read_text())["kind"] == "homography"


@pytest.mark.parametrize("words", [("calibrate", "typed", "--set", "origin=700 -260", "--out"),
                                   ("calibration", "show", "lattice", "--picture")])  # fmt: skip
def test_a_place_that_cannot_be_written_is_named(
    cell: Cell, tmp_path: Path, state: Path, words: tuple[str, ...]
) -> None:
    (tmp_path / "taken").write_text("a file")
    target = "taken" if words[-1] == "--out" else "taken/over.png"
    if words[-1] == "--picture":
        words = ("calibration", "show", "homography", "--picture")
        cell("calibrate", "laid")
    said = cell(*words, target)
    assert said.code == 3
    assert target in said.err
    assert "[Errno" not in said.err
    if words[-1] == "--out":
        assert "nothing was measured" in said.err
        assert Archive(state / "calibrations").all() == ()


def test_a_copy_that_fails_after_all_tells_that_the_calibration_is_kept(
    cell: Cell, tmp_path: Path, state: Path
) -> None:
    from console.calibrate import _write_copy
    from console.exits import ConsoleError

    cell("calibrate", "typed", "--set", "origin=700 -260")
    (tmp_path / "taken").write_text("a file")
    (record,) = Archive(state / "calibrations").current()
    with pytest.raises(ConsoleError, match=r"taken: .*itself is kept") as failed:
        _write_copy(record, {}, tmp_path / "taken")
    assert failed.value.exit == 3


def test_notes_that_cannot_be_locked_are_named(cell: Cell, state: Path) -> None:
    state.mkdir(parents=True)
    (state / "calibration-runs").write_text("a file")
    said = cell("calibrate", "typed", "--set", "origin=700 -260")
    assert said.code == 3
    assert "calibration-runs" in said.err
    assert "nothing was begun" in said.err
    assert "[Errno" not in said.err


def test_an_interrupted_run_is_neither_dropped_nor_gone_on_with_unasked(
    cell: Cell, tmp_path: Path, state: Path
) -> None:
    assert child(tmp_path, 2, "unmade", "calibrate", "laid") == -signal.SIGKILL
    said = cell("calibrate", "laid")
    assert said.code == 2
    assert "a run of laid was interrupted at 20" in said.err
    assert "--resume goes on with it, --anew throws it away" in said.err
    assert cell("calibrate", "laid", "--resume", "--anew").code == 2
    said = cell("calibrate", "laid", "--anew")
    assert said.code == 0
    assert "going on" not in said.err
    assert Archive(state / "calibrations").all() != ()


@pytest.mark.parametrize(("words", "goes_on"), [(("",), True), (("maybe", "no"), False)])
def test_at_a_terminal_going_on_is_the_default(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], goes_on: bool
) -> None:
    from console.asking import ask_yes

    assert ask_yes("Go on?", lines(*words)) is goes_on
    assert ("yes or no is expected, not 'maybe'" in capsys.readouterr().err) is not goes_on


def test_what_is_based_on_another_tells_what_became_of_that(cell: Cell, state: Path) -> None:
    from calibration.record import CalibrationRecord
    from console.calibration import _base_word

    words = ("calibrate", "typed", "--set", "origin=700 -260")
    first = str(cell(*words, "--json").data()["identity"])
    archive = Archive(state / "calibrations")
    assert _base_word(archive, first, {}) == ""
    assert _base_word(archive, first, {first}) == " (left out)"
    second = str(cell(*words, "--set", "error=0.4", "--json").data()["identity"])
    assert _base_word(archive, first, {}) == " (replaced)"
    cell("calibration", "undo", "lattice", "cell")
    assert _base_word(archive, second, {}) == " (undone)"
    path = state / "calibrations" / "records" / f"{second}.json"
    path.write_text("{}")
    assert _base_word(archive, second, {}) == " (damaged)"
    path.unlink()
    assert _base_word(archive, second, {}) == " (missing)"
    # What stands on a base that is not in force is listed as left out, and named by a check.
    read = CalibrationRecord.model_validate_json(
        (state / "calibrations" / "records" / f"{first}.json").read_bytes()
    )
    support = {"path": "cameras.top.lens", "value": {"f": 1}, "record": "ab" * 32}
    stands = CalibrationRecord.model_validate({**read.model_dump(), "stands_on": [support]})
    archive.keep(stands, {})
    listed = cell("calibration", "list")
    assert "left out" in listed.out.splitlines()[1]
    assert "made with the lens abababab of top, which is not in force" in listed.out
    checked = cell("calibration", "check")
    assert checked.code == 1
    assert "lattice of cell is left out (it was made with" in checked.err
    assert "no calibration of the cell" not in checked.err


def test_two_kinds_are_not_compared(cell: Cell) -> None:
    first = str(cell("calibrate", "typed", "--set", "origin=700 -260", "--json").data()["identity"])
    second = str(cell("calibrate", "laid", "--json").data()["identity"])
    said = cell("calibration", "diff", first[:8], second[:8])
    assert said.code == 2
    assert f"{first[:8]} is a lattice and {second[:8]} a homography" in said.err
    short = cell("calibration", "show", first[0])
    assert short.code == 2


def test_a_missing_picture_is_a_wrong_usage(cell: Cell) -> None:
    said = cell("calibrate", "filed")
    assert said.code == 2
    assert "board.png cannot be read" in said.err


def test_demands_that_nothing_can_meet_are_told(
    cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from cell.profile import profile_text

    monkeypatch.undo()
    for kind in ("STATE", "DATA", "CONFIG"):
        monkeypatch.setenv(f"XDG_{kind}_HOME", str(tmp_path / kind.lower()))
    demands = "[demands]\nhomografy = 1.0\nrecognition = 1.0\nworld = 1.0\n"
    text = f"{profile_text('mash')}\n{demands}"
    (tmp_path / "mine.toml").write_text(text)
    mine = str(tmp_path / "mine.toml")
    said = cell("check", "mash", "--profile", mine)
    assert "[demands] homografy: there is no such calibration; did you mean homography" in said.err
    assert "[demands] recognition: its accuracy is never in mm" in said.err
    assert "no world is known: none is kept; calibrate it: `cell calibrate world`" in said.err
    checked = cell("profile", "check", mine)
    assert checked.code == 0
    assert "did you mean homography?" in checked.out
    assert cell("profile", "check", mine, "--strict").code == 1
    assert len(json.loads(cell("profile", "check", mine, "--json").out)["findings"]) >= 2


def test_what_was_calibrated_before_is_named_as_what_it_stands_on(cell: Cell) -> None:
    cell("calibrate", "typed", "--set", "origin=700 -260")
    first = cell("calibrate", "laid", "--json").data()
    # Measured through no camera and with no block, the lattice stands on nothing.
    assert first["based_on"] == []
    again = cell("calibrate", "typed", "--set", "origin=701 -260", "--json").data()
    assert again["based_on"] == []


def test_a_camera_that_was_changed_is_told_and_its_calibration_left_out(
    cell: Cell, tmp_path: Path
) -> None:
    cell("calibrate", "laid")
    guid = load_profile("mash").cameras["top"].guid
    from cell.profile import profile_text

    (tmp_path / "mine.toml").write_text(profile_text("mash").replace(guid, "00B09D0100000001"))
    said = cell("clean", "--profile", "mine.toml")
    assert said.code == 0
    assert f"it was measured with the camera {guid}" in said.err
    assert "cell calibration undo homography top" in said.err
    assert cell("clean").err == ""


def test_a_damaged_record_is_told_and_the_cell_still_works(cell: Cell, state: Path) -> None:
    cell("calibrate", "typed", "--set", "origin=700 -260")
    (path,) = (state / "calibrations" / "records").glob("*.json")
    path.write_text("{")
    said = cell("clean")
    assert said.code == 0
    assert "the calibration of lattice cell is left out" in said.err


def test_what_is_calibrated_is_what_the_program_knows_and_not_how_the_twin_is(cell: Cell) -> None:
    plain = cell("robot", "lattice", "3", "3", "--json").data()
    cell("calibrate", "typed", "--set", "origin=700 -255")
    known = cell("robot", "lattice", "3", "3", "--json").data()
    assert plain != known
    said = cell("calibration", "undo", "lattice", "cell")
    assert said.code == 0
    assert cell("robot", "lattice", "3", "3", "--json").data() == plain


@pytest.mark.parametrize("noted", ["unnoted", "unmade"])
@pytest.mark.parametrize("seed", [7])
def test_killed_at_a_random_request_a_run_goes_on_and_leaves_no_block_out(
    cell: Cell, state: Path, tmp_path: Path, seed: int, noted: str
) -> None:
    nth = random.Random(f"{seed} {noted}").randint(2, 11)
    assert child(tmp_path, nth, noted, "calibrate", "laid") == -signal.SIGKILL
    said = cell("calibrate", "laid", "--resume", "--json")
    assert said.code == 0, f"killed at {nth}: {said.err}"
    answers = nth - 1 if noted == "unnoted" else nth
    assert f"going on after {answers} answers" in said.err
    (record,) = Archive(state / "calibrations").current()
    assert [sample.label for sample in record.samples] == ["place 1", "place 2", "place 3"]
    assert Ledger(state / "ledger.sqlite").blocks_out() == {}
    assert cell("clean").out == "the table was clean already\n"


def test_ctrl_c_stops_safely_and_the_run_goes_on_later(
    cell: Cell, state: Path, tmp_path: Path
) -> None:
    assert child(tmp_path, 6, "unnoted", "calibrate", "laid", by="SIGINT") == 130
    ledger = Ledger(state / "ledger.sqlite")
    assert list(ledger.blocks_out()) == [CYLINDER]
    ledger.close()
    assert cell("calibrate", "laid", "--resume").code == 0


def test_a_run_does_not_go_on_after_the_profile_changed(cell: Cell, tmp_path: Path) -> None:
    assert child(tmp_path, 5, "unmade", "calibrate", "laid") == -signal.SIGKILL
    cell("calibrate", "typed", "--set", "origin=700 -260")
    said = cell("calibrate", "laid", "--resume")
    assert said.code == 2
    assert "the calibrations in force and the profile changed since it began" in said.err
    assert cell("clean").code == 0


def test_the_same_procedure_is_played_by_one_at_a_time(cell: Cell, state: Path) -> None:
    from calibration.files import sole_user

    with sole_user(state / "calibration-runs" / ".locks" / "typed", "it"):
        said = cell("calibrate", "typed", "--set", "origin=700 -260")
    assert said.code == 3
    assert f"already going on, in process {os.getpid()}" in said.err


def test_a_server_tells_what_is_in_force_and_what_its_cell_demands(
    cell: Cell, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from cell.profile import profile_text
    from console.calibrating import with_calibrations
    from console.serve import _tell_calibrations

    cell("calibrate", "typed", "--set", "origin=700 -260")
    (tmp_path / "mine.toml").write_text(f"{profile_text('mash')}\n[demands]\nlattice = 0.1\n")
    _tell_calibrations(with_calibrations(load_profile(str(tmp_path / "mine.toml"))))
    told = capsys.readouterr().err.splitlines()
    assert told[0].startswith("lattice of cell: OK, 0.5 mm held out, measured ")
    assert told[0].partition("(")[2].startswith("now), ")
    assert "no task will begin" in told[1]
    assert "0.1 mm are demanded, but the lattice of cell has 0.5 mm (held out)" in told[1]


def test_a_check_of_a_script_tells_what_the_cell_is_not_known_well_enough_for(
    cell: Cell, tmp_path: Path
) -> None:
    text = library_script("mash").replace(
        "goal ReachRedCube {\n", "goal ReachRedCube {\n  accuracy 2 mm\n"
    )
    (tmp_path / "fine.cell").write_text(text)
    said = cell("check", "fine.cell")
    assert said.code == 1
    assert "where the lattice lies is not known: no calibration is kept" in said.out
    assert "  accuracy 2 mm\n" in said.out
    assert "^^^^^^^^^^^^^" in said.out
    cell("calibrate", "typed", "--set", "origin=710 -265")
    cell("calibrate", "laid")
    assert cell("check", "fine.cell").code == 0
    cell("calibrate", "laid", "--set", "shift=1.6")
    assert "the homography of top has 3.1 mm (held out)" in cell("check", "fine.cell").out


def lines(*words: str) -> Callable[[str], str]:
    left = list(words)

    def read(prompt: str) -> str:
        if not left:
            raise EOFError
        return left.pop(0)

    return read


def test_a_person_is_asked_again_until_the_answer_is_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from calibration.requests import Ask

    asker = TerminalAsker(tmp_path, lines("wide", "", "2.5", "3"))
    ask = Ask(key="width", question="How wide?", kind="number", unit="mm")
    assert asker.answer(ask) == 2.5
    assert asker.answer(ask) == 3.0
    said = capsys.readouterr().err
    assert "width: a number is expected, not 'wide'" in said
    assert said.count("Ctrl-C stops safely") == 1
    with_default = Ask(key="w", question="?", kind="number", default=7.0)
    assert TerminalAsker(tmp_path, lines("")).answer(with_default) == 7.0
    assert TerminalAsker(tmp_path, lines("")).answer(Ask(key="d", question="?", kind="done"))


def test_a_point_is_asked_with_a_picture_in_a_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import numpy as np

    from calibration.pictures import picture_of
    from calibration.requests import Point

    picture = picture_of("top", np.full((4, 6, 3), 9, np.uint8))
    point = Point(key="hole", question="The hole?", picture=picture, guess_px=(2.0, 1.0))
    assert TerminalAsker(tmp_path, lines("9 9", "5 3")).point(point) == (5.0, 3.0)
    said = capsys.readouterr().err
    path = tmp_path / "point-hole.png"
    assert str(path) in said
    assert (decode_png(path.read_bytes(), "x") == picture.pixels).all()
    assert TerminalAsker(tmp_path, lines("")).point(point) == (2.0, 1.0)


def test_when_nobody_answers_any_more_the_run_can_go_on_later(tmp_path: Path) -> None:
    from calibration.requests import Ask
    from console.exits import ConsoleError

    with pytest.raises(ConsoleError, match=r"width: nobody answers any more; .*--resume"):
        TerminalAsker(tmp_path, lines()).answer(Ask(key="width", question="?", kind="number"))


def test_figures_are_told_in_units_that_people_read() -> None:
    from calibration.record import Accuracy, Parameter, Sample
    from console.calibration_views import _parameters, _short, verdict_lines
    from tests.calibration.records import a_record

    share = Accuracy(held_out_rms=0.0, held_out_count=9, how="fresh", unit="% wrong")
    record = a_record().model_copy(
        update={
            "accuracy": share,
            "samples": (Sample(label="one"),),
            "parameters": (Parameter(name="angle", value=0.5, unit="rad", deviation=0.01),),
        }
    )
    assert "  held out   0 % wrong (9 points: fresh)" in verdict_lines(record)
    assert _parameters(record) == ["angle = 28.6479 ± 0.57 deg"]
    assert _short([[1.23456789, 2.0], {"x": 1e-9 / 3}]) == "[[1.23457, 2.0], {'x': 3.33333e-10}]"
