"""The arms of the avrs and lynx cells by hand, each command in a process's state of its own."""

from __future__ import annotations

import io
from importlib import resources
from pathlib import Path

import pytest

from cell.lock import CellLock
from console.places import cell_folder
from tests.console.hands import Cell, caller


@pytest.fixture
def cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Cell:
    return caller(tmp_path, monkeypatch, capsys)


def lynx(cell: Cell) -> Cell:
    """Return what calls a command on the Lynx once it is open."""
    assert cell("robot", "open", "--profile", "lynx").code == 0
    return lambda *words: cell(*words, "--profile", "lynx")


def scara(cell: Cell) -> Cell:
    assert cell("robot", "open", "--profile", "avrs").code == 0
    return lambda *words: cell(*words, "--profile", "avrs")


def confirming(tmp_path: Path) -> str:
    """Return the path of a lynx profile that wants its first pose confirmed."""
    text = (resources.files("cell") / "profiles" / "lynx.toml").read_text("utf-8")
    path = tmp_path / "careful.toml"
    text = text.replace('first_pose = "announced"', 'first_pose = "confirmed"')
    path.write_text(text.replace('name = "lynx"', 'name = "careful"'), "utf-8")
    return str(path)


@pytest.mark.parametrize("name", ["avrs", "lynx"])
@pytest.mark.parametrize("what", ["pose", "joints"])
def test_a_freshly_powered_arm_does_not_pretend_to_know_where_it_is(
    cell: Cell, name: str, what: str
) -> None:
    said = cell("robot", what, "--profile", name)
    assert said.code == 3
    assert "power-up" in said.err
    assert said.out == ""


def test_opening_tells_what_will_move(cell: Cell) -> None:
    assert "looks for its home" in cell("robot", "open", "--profile", "avrs").err
    assert "jump at full speed" in cell("robot", "open", "--profile", "lynx").err
    again = cell("robot", "open", "--profile", "lynx", "--show-wire")
    assert "jump" not in again.err
    assert "arm > #" not in again.err


def test_the_lynx_stands_where_an_earlier_command_left_it(cell: Cell) -> None:
    arm = lynx(cell)
    assert arm("robot", "joints", "20", "-20", "40", "40", "0").code == 0
    data = arm("robot", "joints", "--json").data()
    found = [data[f"j{n}"] for n in range(1, 6)]
    assert found == pytest.approx([20, -20, 40, 40, 0], abs=1.1)  # Pulses are told in 10 us.
    before = arm("robot", "pose", "--json").data()
    assert arm("robot", "jog", "z", "15").code == 0
    after = arm("robot", "pose", "--json").data()
    assert float(str(after["z_mm"])) == pytest.approx(float(str(before["z_mm"])) + 15, abs=5)
    assert arm("robot", "home").code == 0
    assert arm("robot", "rest").code == 0


def test_the_scara_stands_where_an_earlier_command_left_it_and_does_not_home_again(
    cell: Cell,
) -> None:
    arm = scara(cell)
    assert arm("robot", "joints", "45", "105", "-20", "0").code == 0
    moved = arm("robot", "jog", "z", "-30")
    assert moved.code == 0
    assert "home" not in moved.err
    data = arm("robot", "pose", "--json").data()
    assert data["z_mm"] == pytest.approx(-50, abs=0.05)
    assert arm("robot", "move", "300", "500").code == 0
    data = arm("robot", "pose", "--json", "--wires", "pty").data()
    assert (data["x_mm"], data["y_mm"]) == pytest.approx((300, 500), abs=0.1)
    assert arm("robot", "home").code == 0


def test_the_guard_refuses_on_these_arms_too(cell: Cell) -> None:
    arm = scara(cell)
    arm("robot", "joints", "45", "105", "-20", "0")
    assert arm("robot", "move", "300", "500").code == 0
    refused = arm("robot", "move", "300", "500", "-240", "--json")
    assert refused.code == 1
    assert refused.data()["limit"] == pytest.approx(-231.3, abs=0.1)
    assert lynx(cell)("robot", "speed", "5000").code == 1


@pytest.mark.parametrize("name", ["avrs", "lynx"])
@pytest.mark.parametrize(
    "words",
    ["robot lattice 1 1", "robot magnet on", "tv state", "lights on", "camera list",
     "store where", "gripper list"],
)  # fmt: skip
def test_what_needs_a_playground_says_that_there_is_none(cell: Cell, name: str, words: str) -> None:
    said = cell(*words.split(), "--profile", name)
    assert said.code == 2
    assert f"the cell {name} has no playground" in said.err
    assert said.out == ""


def test_state_alarm_stop_and_close_move_nothing_on_a_fresh_arm(cell: Cell) -> None:
    for name in ("avrs", "lynx"):
        for words in (("state",), ("alarm",), ("alarm", "--reset"), ("stop",), ("close",)):
            assert cell("robot", *words, "--profile", name).code == 0
        assert cell("robot", "pose", "--profile", name).code == 3


def test_closing_says_how_the_arm_stays_behind(cell: Cell) -> None:
    assert "friction holds" in scara(cell)("robot", "close").out
    assert "go on holding it" in lynx(cell)("robot", "close").out


def test_the_fingers_of_the_lynx_keep_their_opening(cell: Cell) -> None:
    fingers = lynx(cell)
    assert fingers("gripper", "state", "--json").data()["referenced"] is False
    assert fingers("gripper", "open").code == 0
    assert fingers("gripper", "move", "10").code == 0
    state = fingers("gripper", "state", "--json").data()
    assert state["position_mm"] == pytest.approx(10, abs=0.5)
    assert fingers("gripper", "close").code == 0
    beyond = fingers("gripper", "move", "80")
    assert (beyond.code, "allowed are -15.0 to 30.0 mm" in beyond.err) == (1, True)


def test_a_blind_grip_claims_nothing(cell: Cell) -> None:
    for name in ("avrs", "lynx"):
        said = cell("gripper", "grip", "--profile", name, "--json")
        assert said.code == 0
        assert said.data() == {"holding": None, "width_mm": None}


def test_a_valve_that_this_program_did_not_work_is_not_known(cell: Cell) -> None:
    state = cell("gripper", "state", "--profile", "avrs", "--json").data()
    assert state["referenced"] is False
    assert "no register tells" in str(state["error_text"])
    assert cell("gripper", "move", "31", "--profile", "avrs").code == 1


def test_fingers_that_the_profile_leaves_out_are_a_sentence(cell: Cell, tmp_path: Path) -> None:
    path = Path(confirming(tmp_path))
    text = path.read_text("utf-8").replace("[arm.fingers]", "[arm.fingers]\nenabled = false")
    path.write_text(text, "utf-8")
    said = cell("gripper", "state", "--profile", str(path))
    assert (said.code, "leaves the fingers out" in said.err) == (2, True)


# The first pose


def test_a_first_pose_that_nobody_confirms_is_not_taken(cell: Cell, tmp_path: Path) -> None:
    profile = confirming(tmp_path)
    for words in (("open",), ("rest",), ("joints", "0", "0", "0", "0", "0")):
        said = cell("robot", *words, "--profile", profile, "--show-wire")
        assert said.code == 2
        assert "--first-pose" in said.err
        assert "jump at full speed" in said.err
        assert "arm > #" not in said.err
    assert cell("robot", "pose", "--profile", profile).code == 3


def test_a_confirmed_first_pose_is_taken_once(cell: Cell, tmp_path: Path) -> None:
    profile = confirming(tmp_path)
    opened = cell("robot", "open", "--first-pose", "--profile", profile, "--show-wire")
    assert opened.code == 0
    orders = [line for line in opened.err.splitlines() if line.startswith("arm > #")]
    assert [order.split("P")[0] for order in orders] == [
        "arm > #1", "arm > #2", "arm > #3", "arm > #5", "arm > #0",
    ]  # fmt: skip
    again = cell("robot", "open", "--profile", profile)
    assert again.code == 0
    assert cell("robot", "rest", "--profile", profile).code == 0


@pytest.mark.parametrize(("answer", "code"), [("y\n", 0), ("n\n", 2), ("\n", 2), ("", 2)])
def test_at_a_terminal_it_is_asked(
    cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answer: str, code: int
) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr("sys.stdin", Terminal(answer))
    said = cell("robot", "rest", "--profile", confirming(tmp_path))
    assert said.code == code
    assert "stand clear" in said.err
    assert "[y/N]" in said.err


# What is kept


@pytest.mark.parametrize("name", ["avrs", "lynx"])
def test_an_arm_that_somebody_has_is_left_alone(cell: Cell, name: str) -> None:
    for wires in ("memory", "hardware"):
        lock = CellLock(cell_folder(name))
        try:
            said = cell("robot", "state", "--profile", name, "--wires", wires)
            assert (said.code, "in use by process" in said.err) == (3, True)
        finally:
            lock.release()
    assert cell("robot", "state", "--profile", name).code == 0


@pytest.mark.parametrize(
    "text", ["", "{", '{"format": 2}', '{"format": 1}', "[]", '{"format": 1, "ssc32": {}}']
)
def test_a_spoiled_file_is_a_sentence_and_gives_the_cell_back(cell: Cell, text: str) -> None:
    folder = cell_folder("avrs")
    folder.mkdir(parents=True)
    (folder / "arm.json").write_text(text, "utf-8")
    for _ in range(2):
        said = cell("robot", "state", "--profile", "avrs")
        assert said.code == 3
        assert "remove it to start with a freshly powered arm" in said.err
