"""Whatever is typed wrongly: a sentence and an exit code, never a traceback."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.console.hands import Cell, caller

WRONG = [
    # (words, exit code, what the sentence must hold)
    ("robot dance", 2, "dance"),
    ("robot move", 2, "X_MM"),
    ("robot move 1", 2, "Y_MM"),
    ("robot move a b", 2, "a"),
    ("robot move 600 0 200 5 5", 2, ""),
    ("robot move nan 0", 2, "nan"),
    ("robot move inf 0", 2, "inf"),
    ("robot move 600 0 --rotation north", 2, "north"),
    ("robot move 600 0 --profile nope", 2, "nope"),
    ("robot move 600 0 --wires string", 2, "string"),
    ("robot move 600 0 --nonsense", 2, "--nonsense"),
    ("robot move 5000 5000", 1, "nearest allowed"),
    ("robot move 600 0 10", 1, "nearest allowed"),
    ("robot move 0 0", 1, ""),
    ("robot move -- -1e308 0 300", 1, "tool x is out of reach: -1e+308 mm asked"),
    ("robot move 500,0 0", 2, "X_MM: '500,0' is no number; a number with a decimal point"),
    ("robot move 500 0 300 --rotation 1,5", 2, "--rotation: '1,5' is no number"),
    ("robot move 500 0 300 --rotation 1e9", 1, "tool c is turned by more than a whole turn"),
    ("robot move 500 0 300 --rotation=-361", 1, "limit -360.0 deg"),
    ("robot lattice", 2, "X"),
    ("robot lattice one 2", 2, "X: 'one' is no whole number"),
    ("robot lattice 999999999999999999999 0", 2, "X: '999999999999999999999' is no number that"),
    ("robot lattice 99999999999 0", 1, "nearest allowed"),
    ("robot joints 0 0 90 0 1e20 0", 1, "J5 would pass its limit: 1e+20 deg asked"),
    ("robot jog j1 1e300", 1, "nearest allowed 170.0 deg"),
    ("robot jog x 1e308", 1, "tool x is out of reach"),
    ("robot lattice 1.5 2", 2, "1.5"),
    ("robot lattice 100 100", 1, "nearest allowed"),
    ("robot lattice 3 3 --height 5", 1, "nearest allowed"),
    ("robot joints 1 2 3", 2, "6 joints"),
    ("robot joints 1 2 3 4 5 6 7", 2, "6 joints"),
    ("robot joints a", 2, "a"),
    ("robot joints 400 0 0 0 0 0", 1, "nearest allowed 170.0 deg"),
    ("robot joints nan 0 90 0 90 0", 2, "nan"),
    ("robot jog", 2, "AXIS"),
    ("robot jog w 5", 2, "'w' is no axis"),
    ("robot jog j9 5", 2, "j1 to j6"),
    ("robot jog x far", 2, "far"),
    ("robot jog z -2000", 1, "nearest allowed"),
    ("robot jog j1 720", 1, "nearest allowed"),
    ("robot speed 0", 1, "nearest allowed"),
    ("robot speed 100 200", 1, "limit 100.0 %"),
    ("robot speed fast", 2, "fast"),
    ("robot magnet maybe", 2, "maybe"),
    ("robot pose --profile avrs.toml", 2, "avrs.toml"),
    ("robot pose --script nope", 2, "nope"),
    ("gripper squeeze", 2, "squeeze"),
    ("gripper move", 2, "OPENING_MM"),
    ("gripper move wide", 2, "wide"),
    ("gripper move -1", 1, "out of reach"),
    ("gripper move 71", 1, "out of reach"),
    ("gripper move nan", 2, "nan"),
    ("gripper grip --current 0", 1, "current"),
    ("gripper grip --current 100", 1, "current"),
    ("gripper wait 3 --timeout 0", 2, "timeout"),
    ("gripper wait 3 --timeout -1", 2, "timeout"),
    ("gripper list --upto 0", 2, "upto"),
    ("gripper list --upto 256", 2, "upto"),
    ("tv input", 2, "NUMBER"),
    ("tv input 0", 1, "HDMI"),
    ("tv input one", 2, "one"),
    ("tv volume -1", 1, "0 to 60"),
    ("tv volume 61", 1, "0 to 60"),
    ("tv picture", 2, "NAME"),
    ("tv picture cat", 2, "black, white"),
    ("lights dim", 2, "dim"),
    ("lights on off", 2, "off"),
    ("camera grab", 2, "NAME"),
    ("camera grab side", 2, "there are oblique, top, gripper"),
    ("camera grab top --size 10x10", 2, "640x480"),
    ("camera grab top --size big", 2, "640x480"),
    ("camera grab top --out top.jpg", 2, ".png"),
    ("camera grab top --out /proc/none/top.png", 3, "/proc/none"),
    ("camera grab top --set shutter", 2, "FEATURE=NUMBER"),
    ("camera grab top --set zoom=3", 2, "no feature 'zoom'"),
    ("camera grab top --set shutter=0", 1, "allowed"),
    ("camera features side", 2, "oblique"),
    ("camera set top shutter", 2, "VALUE"),
    ("camera set top shutter long", 2, "long"),
    ("camera set top shutter 1e9", 1, "allowed"),
    ("camera set top sharpness 1.5 --raw", 2, "whole numbers"),
    ("camera set top sharpness 99999 --raw", 1, "allowed"),
    ("camera set side shutter 1", 2, "oblique"),
    ("camera auto top shutter maybe", 2, "maybe"),
    ("camera auto top zoom on", 2, "no feature"),
    ("store where sphere", 2, "cube red"),
    ("store where cube pink", 2, "cube red"),
    ("store grip 1", 2, "Y_MM"),
    ("store grip 600 0", 1, "no block within"),
    ("store release 600 0", 1, "no block"),
    ("store deploy 99 600 0", 1, "no slot 99"),
    ("store deploy 7 5000 0", 1, "nearest allowed"),
    ("store deploy 7 1e300 0", 1, "tool x is out of reach"),
    ("store deploy seven 1 1", 2, "seven"),
    ("store clean 99", 1, "no slot 99"),
    ("store clean 7 --picture", 2, "leave the slots out"),
    ("watchdog history --rounds 0", 2, "--rounds"),
    ("watchdog history --rounds -1", 2, "--rounds"),
    ("watchdog history --rounds 1000001", 2, "--rounds"),
    ("watchdog history --rounds 99999999999999999999", 2, "--rounds"),
    ("watchdog history --rounds ten", 2, "--rounds"),
    ("profile new", 2, "NAME"),
    ("profile new mash", 2, "shipped"),
    ("profile new a/b", 2, "a/b"),
    ("profile new mine --from nope", 2, "nope"),
    ("profile new mine --out mine.txt", 2, ".toml"),
    ("profile check nope", 2, "nope"),
    ("profile check nope.toml", 2, "nope.toml"),
    ("profile check /", 2, "cannot be read"),
    ("profile show broken.toml", 2, "unknown key `nmae`"),
    ("profile diff mash", 2, "SECOND"),
    ("profile diff mash nope", 2, "nope"),
    ("profile diff mash broken.toml", 2, "broken.toml cannot be used"),
    ("robot pose --profile broken.toml", 2, "did you mean `name`?"),
]


@pytest.fixture
def cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Cell:
    return caller(tmp_path, monkeypatch, capsys)


@pytest.mark.parametrize(("line", "code", "hint"), WRONG, ids=[line for line, _, _ in WRONG])
def test_wrong_input_is_a_sentence_and_its_exit_code(
    line: str, code: int, hint: str, cell: Cell, tmp_path: Path
) -> None:
    (tmp_path / "broken.toml").write_text('nmae = "x"\n', "utf-8")
    said = cell(*line.split())
    assert said.code == code, said.err
    assert hint.lower() in said.err.lower()
    assert "Traceback" not in said.err + said.out
    assert "unexpected" not in said.err


@pytest.mark.parametrize("line", ["tv volume 101", "tv volume -1", "tv input 99", "tv input 0"])
def test_a_television_in_standby_stays_there_when_a_figure_is_out_of_range(
    line: str, cell: Cell
) -> None:
    assert cell("tv", "off").code == 0
    assert cell(*line.split()).code == 1
    assert cell("tv", "state", "--json").data()["on"] is False


def test_a_folder_that_is_made_for_a_picture_is_told(cell: Cell, tmp_path: Path) -> None:
    said = cell("camera", "grab", "top", "--size", "640x480", "--out", "new/one/top.png")
    assert said.code == 0, said.err
    assert "made the folder new/one" in said.err
    assert (tmp_path / "new" / "one" / "top.png").is_file()
    again = cell("camera", "grab", "top", "--size", "640x480", "--out", "new/one/top.png")
    assert "made the folder" not in again.err


def test_there_are_many_ways_to_be_wrong() -> None:
    assert len(WRONG) >= 60
