from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import cv2
import pytest

from cell.lock import CellLock
from console.places import cell_folder
from tests.console.cli import command, environment
from tests.console.hands import Cell, Said, caller


@pytest.fixture
def cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Cell:
    return caller(tmp_path, monkeypatch, capsys)


def place(said: Said) -> tuple[float, float, float]:
    data = said.data()
    x_mm, y_mm, z_mm = data["x_mm"], data["y_mm"], data["z_mm"]
    assert isinstance(x_mm, float)
    assert isinstance(y_mm, float)
    assert isinstance(z_mm, float)
    return x_mm, y_mm, z_mm


def servos_sent(said: Said) -> bool:
    return "SRVON" in said.err


# The arm


def test_the_arm_stands_where_an_earlier_command_left_it(cell: Cell) -> None:
    assert cell("robot", "lattice", "3", "3").code == 0
    assert place(cell("robot", "pose", "--json")) == pytest.approx((650, -205, 200), abs=0.1)
    assert cell("robot", "move", "600", "-200", "220", "--rotation", "170").code == 0
    assert place(cell("robot", "pose", "--json")) == pytest.approx((600, -200, 220), abs=0.1)


def test_the_arm_comes_up_and_tells_who_it_is(cell: Cell) -> None:
    said = cell("robot", "open", "--json")
    assert "RV-6SDL" in str(said.data()["identity"])
    kept = cell("robot", "open", "--keep", "--show-wire")
    assert "SRVOFF" not in kept.err
    closed = cell("robot", "close", "--show-wire")
    assert closed.code == 0
    assert "SRVOFF" in closed.err


def test_joints_are_told_and_moved(cell: Cell) -> None:
    assert cell("robot", "joints", "10", "0", "90", "0", "80", "0").code == 0
    data = cell("robot", "joints", "--json").data()
    assert [data[f"j{n}"] for n in range(1, 7)] == pytest.approx([10, 0, 90, 0, 80, 0], abs=0.01)
    assert cell("robot", "joints").out.startswith("J1 10.00")


def test_jogging_moves_one_axis(cell: Cell) -> None:
    cell("robot", "lattice", "3", "3")
    x_mm, y_mm, z_mm = place(cell("robot", "pose", "--json"))
    assert cell("robot", "jog", "x", "-10").code == 0
    assert cell("robot", "jog", "z", "15.5").code == 0
    moved = place(cell("robot", "pose", "--json"))
    assert moved == pytest.approx((x_mm - 10, y_mm, z_mm + 15.5), abs=0.1)
    before = cell("robot", "joints", "--json").data()["j1"]
    assert cell("robot", "jog", "j1", "5").code == 0
    assert cell("robot", "joints", "--json").data()["j1"] == pytest.approx(float(str(before)) + 5)


def test_the_speed_is_kept_for_later_moves(cell: Cell) -> None:
    assert cell("robot", "speed").out == "250 mm/s along lines, 30 % of full speed in joint moves\n"
    assert cell("robot", "speed", "120", "15").code == 0
    assert cell("robot", "speed", "--json").data() == {"speed_mm_s": 120.0, "joint_percent": 15.0}
    assert "SPD 120" in cell("robot", "lattice", "3", "3", "--show-wire").err.replace("EXEC", "")


def test_a_kept_speed_that_cannot_be_read_is_as_if_there_were_none(cell: Cell) -> None:
    cell("robot", "speed", "120")
    (cell_folder("mash") / "speed-by-hand.json").write_text("{", "utf-8")
    assert cell("robot", "speed", "--json").data()["speed_mm_s"] == 250


def test_rest_and_home_stand_aside(cell: Cell) -> None:
    for word in ("rest", "home"):
        cell("robot", "lattice", "3", "3", "--height", "150")
        assert cell("robot", word).code == 0
        assert cell("robot", "joints", "--json").data()["j1"] == pytest.approx(90)


def test_looking_at_the_arm_needs_no_servos(cell: Cell) -> None:
    for words in (("pose",), ("joints",), ("state",), ("alarm",), ("stop",), ("alarm", "--reset")):
        said = cell("robot", *words, "--show-wire")
        assert said.code == 0, said.err
        assert "arm > " in said.err
        assert not servos_sent(said), words
    assert cell("robot", "alarm", "--json").data() == {"alarm": 0, "text": ""}
    state = cell("robot", "state", "--json").data()
    assert (state["servos_on"], state["automatic"], state["alarm"]) == (False, True, 0)


def test_stop_goes_out_on_the_wire(cell: Cell) -> None:
    assert "1;1;STOP" in cell("robot", "stop", "--show-wire").err


def test_the_guard_says_what_by_how_much_and_the_nearest_allowed(cell: Cell) -> None:
    said = cell("robot", "move", "600", "-200", "20", "--json")
    assert said.code == 1
    refused = said.data()
    assert set(refused) >= {"refused", "what", "value", "limit", "nearest", "unit"}
    assert "nearest allowed" in said.err
    assert "asked" in said.err
    too_fast = cell("robot", "speed", "5000")
    assert too_fast.code == 1
    assert "5000.0 mm/s asked, limit 1000.0 mm/s" in too_fast.err
    assert cell("robot", "joints", "0", "0", "90", "0", "120", "0").code == 1


def test_a_refused_move_leaves_the_arm_where_it_was(cell: Cell) -> None:
    before = cell("robot", "pose").out
    assert cell("robot", "move", "2000", "0").code == 1
    assert cell("robot", "pose").out == before


# Gripper, lights, magnet


def test_the_gripper_opens_moves_grips_and_closes(cell: Cell) -> None:
    opened = cell("gripper", "open", "--json").data()
    assert opened["referenced"] is True
    assert cell("lights").out == "the lights are on\n"
    assert cell("gripper", "move", "40", "--json").data()["position_mm"] == pytest.approx(40, abs=1)
    assert cell("gripper", "wait", "40").code == 0
    empty = cell("gripper", "grip", "--current", "0.5", "--json")
    assert (empty.code, empty.data()["holding"]) == (1, False)
    assert cell("gripper", "wait").code == 0
    assert cell("gripper", "close").code == 0
    assert cell("gripper", "state", "--json").data()["referenced"] is False


def test_the_gripper_is_looked_at_without_moving_and_without_servos(cell: Cell) -> None:
    for word in ("state", "stop", "ack"):
        said = cell("gripper", word, "--show-wire")
        assert said.code == 0, said.err
        assert not servos_sent(said)
    before = cell("gripper", "state", "--json").data()["position_mm"]
    assert cell("gripper", "state", "--json").data()["position_mm"] == before


def test_power_is_put_back_as_it_was_found(cell: Cell) -> None:
    cell("gripper", "state")
    assert cell("gripper", "state", "--json").data()["referenced"] is False
    cell("gripper", "open")
    cell("gripper", "state")
    assert cell("gripper", "state", "--json").data()["referenced"] is True


def test_the_modules_on_the_line_are_listed(cell: Cell) -> None:
    assert cell("gripper", "list", "--upto", "12").out.startswith("12  PG0")
    none = cell("gripper", "list", "--upto", "2")
    assert (none.code, none.out) == (1, "no module answers\n")


def test_an_opening_beyond_the_stroke_is_a_sentence(cell: Cell) -> None:
    said = cell("gripper", "move", "80", "--json")
    assert said.code == 1
    assert "allowed are 0.0 to 70.0 mm, nearest is 70.0 mm" in said.err
    assert "held" not in said.err
    assert "70.0 mm" in str(said.data()["refused"])
    too_strong = cell("gripper", "grip", "--current", "50")
    assert (too_strong.code, "above 0 up to 2 A" in too_strong.err) == (1, True)


def test_lights_and_magnet_need_no_servos(cell: Cell) -> None:
    on = cell("lights", "on", "--show-wire")
    assert not servos_sent(on)
    assert cell("lights", "--json").data() == {"on": True}
    cell("lights", "off")
    assert cell("lights").out == "the lights are off\n"
    assert not servos_sent(cell("robot", "magnet", "on", "--show-wire"))


# Television and cameras


def test_the_television_by_hand(cell: Cell) -> None:
    assert cell("tv", "on").out == "the television is on, input 1\n"
    assert cell("tv", "input", "2", "--json").data() == {"input": 2}
    assert cell("tv", "volume", "30").out == "volume 30\n"
    assert cell("tv", "picture", "forest").out == "the screen shows forest\n"
    assert cell("tv", "off").out == "the television is in standby\n"
    state = cell("tv", "state", "--json").data()
    assert state["on"] is False
    assert "arm" not in cell("tv", "state", "--show-wire").err


def test_what_the_television_refuses_is_a_sentence(cell: Cell) -> None:
    assert cell("tv", "input", "99").code == 1
    volume = cell("tv", "volume", "70")
    assert (volume.code, "0 to 60" in volume.err) == (1, True)


def test_a_picture_is_taken_in_the_size_asked(cell: Cell, tmp_path: Path) -> None:
    cell("lights", "on")
    said = cell("camera", "grab", "top", "--size", "640x480", "--out", "pictures/one.png")
    assert said.out == "pictures/one.png\n"
    bright = cv2.imread(str(tmp_path / "pictures" / "one.png"))
    assert bright is not None
    assert bright.shape == (480, 640, 3)
    cell("camera", "grab", "top", "--size", "640x480", "--set", "shutter=1", "--out", "dark.png")
    dark = cv2.imread(str(tmp_path / "dark.png"))
    assert dark is not None
    assert dark.mean() < bright.mean() / 2


def test_cameras_tell_who_they_are_and_what_they_can(cell: Cell) -> None:
    listed = json.loads(cell("camera", "list", "--json").out)
    assert [one["name"] for one in listed] == ["oblique", "top", "gripper"]
    assert all(one["guid"] in one["found"] for one in listed)
    features = json.loads(cell("camera", "features", "top", "--json").out)
    shutter = next(one for one in features if one["name"] == "shutter")
    assert shutter["unit"] == "ms"
    assert "shutter" in cell("camera", "features", "top").out


def test_a_feature_is_set_and_read_back(cell: Cell) -> None:
    assert cell("camera", "set", "top", "shutter", "20", "--json").data()["absolute"] == (
        pytest.approx(20, rel=0.01)
    )
    assert cell("camera", "set", "top", "sharpness", "500", "--raw", "--json").data()["raw"] == 500
    assert cell("camera", "set", "top", "gain", "-5").code == 0
    assert "set by the camera" in cell("camera", "auto", "top", "shutter", "on").out
    refused = cell("camera", "set", "top", "shutter", "100000")
    assert refused.code == 1
    assert "allowed 0.01 to 533.333 ms" in refused.err
    assert cell("camera", "set", "top", "shutter", "nan").code == 2
    dark = cell("camera", "grab", "top", "--set", "shutter=100000")
    assert (dark.code, "allowed" in dark.err) == (1, True)


# Blocks


def lies(cell: Cell, slot: int) -> object:
    rows = json.loads(cell("store", "where", "--json").out)
    return next(row["now_mm"] for row in rows if row["slot"] == slot)


def test_a_block_is_laid_out_gripped_carried_and_brought_home(cell: Cell) -> None:
    assert cell("store", "deploy", "7", "500", "0").code == 0
    assert lies(cell, 7) == [500.0, 0.0]
    assert cell("store", "grip", "500", "0", "--json").data() == {"slot": 7}
    assert cell("robot", "state").code == 0
    assert cell("store", "release", "520", "60", "--yaw", "0").code == 0
    assert lies(cell, 7) == [520.0, 60.0]
    assert cell("store", "clean", "7", "--json").data() == {"brought_home": [7], "left": []}
    assert lies(cell, 7) is None


def test_everything_is_brought_home_by_ledger_and_by_picture(cell: Cell) -> None:
    cell("store", "deploy", "7", "500", "0")
    assert cell("store", "clean").out == "brought home: slot 7\n"
    assert cell("store", "clean").out == "nothing was brought home\n"
    cell("store", "deploy", "16", "500", "100")
    assert cell("store", "clean", "--picture").out == "brought home: slot 16\n"


def test_the_store_says_where_blocks_belong(cell: Cell) -> None:
    rows = json.loads(cell("store", "where", "cube", "red", "--json").out)
    assert [row["slot"] for row in rows] == [7, 8]
    assert "belongs at mm" in cell("store", "where", "bridge").out


def test_no_block_and_no_slot_are_exit_code_1(cell: Cell) -> None:
    assert cell("store", "grip", "600", "0").code == 1
    assert cell("store", "release", "600", "0").code == 1
    assert cell("store", "deploy", "99", "1", "1").code == 1


# Wires, locks, stops


def test_pseudo_terminals_do_the_same(cell: Cell) -> None:
    assert cell("robot", "lattice", "2", "2", "--wires", "pty").code == 0
    assert cell("gripper", "state", "--wires", "pty").code == 0
    assert cell("robot", "pose").out == cell("robot", "pose", "--wires", "pty").out


def test_a_port_that_is_not_there_is_exit_code_3(cell: Cell) -> None:
    said = cell("robot", "pose", "--wires", "hardware")
    assert said.code == 3
    assert "COM9" in said.err


def test_a_cell_that_somebody_has_is_left_alone(cell: Cell) -> None:
    lock = CellLock(cell_folder("mash"))
    try:
        said = cell("robot", "pose")
        assert said.code == 3
        assert "in use by process" in said.err
    finally:
        lock.release()
    assert cell("robot", "pose").code == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_stops_the_arm_on_the_wire(number: signal.Signals, tmp_path: Path) -> None:
    words = ("robot", "joints", "-90", "0", "90", "0", "90", "0", "--real-time", "--show-wire")
    process = subprocess.Popen(
        command(words), env=environment(tmp_path), stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    wire = []
    for line in process.stderr:
        wire.append(line)
        if line.startswith("arm > ") and "MOV" in line.upper():
            break
    process.send_signal(number)
    out, rest = process.communicate(timeout=60)
    assert process.returncode == 130, rest
    after = [line for line in rest.splitlines() if line.startswith("arm > ")]
    assert any(line.endswith("STOP\\r") for line in after[:2]), after
    assert "the arm stands still" in rest
    assert "Traceback" not in rest
    assert out == ""


# What television and cameras keep


def test_the_television_stays_as_it_was_left(cell: Cell) -> None:
    assert cell("tv", "state", "--json").data()["on"] is False
    cell("tv", "on")
    cell("tv", "volume", "33")
    cell("tv", "input", "2")
    cell("tv", "picture", "forest")
    state = cell("tv", "state", "--json").data()
    assert (state["on"], state["input"], state["volume"]) == (True, 1, 33)
    assert state["picture"] == "forest"
    cell("tv", "off")
    assert cell("tv", "state", "--json").data()["on"] is False


def test_a_feature_of_a_camera_stays_as_it_was_set(cell: Cell) -> None:
    cell("camera", "set", "top", "shutter", "20")
    cell("camera", "auto", "top", "gain", "on")
    features = {
        one["name"]: one for one in json.loads(cell("camera", "features", "top", "--json").out)
    }
    assert features["shutter"]["absolute"] == pytest.approx(20, rel=0.01)
    assert features["gain"]["control"] != "manual"
    other = json.loads(cell("camera", "features", "oblique", "--json").out)
    shutter = next(one for one in other if one["name"] == "shutter")
    assert shutter["absolute"] == pytest.approx(149.869, rel=0.01)


def test_devices_begin_anew_when_somebody_else_had_the_world(cell: Cell) -> None:
    cell("tv", "on")
    world = cell_folder("mash") / "world.json"
    world.write_text(world.read_text("utf-8"), "utf-8")
    assert cell("tv", "state", "--json").data()["on"] is False


def test_a_world_of_before_still_loads_and_spoiled_devices_are_a_sentence(cell: Cell) -> None:
    cell("robot", "lattice", "3", "3")
    kept = cell_folder("mash") / "devices.json"
    kept.unlink()
    assert place(cell("robot", "pose", "--json")) == pytest.approx((650, -205, 200), abs=0.1)
    kept.write_text("{", "utf-8")
    for _ in range(2):
        said = cell("tv", "state")
        assert (said.code, "does not hold the twin's television" in said.err) == (3, True)
