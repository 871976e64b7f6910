"""`cell webcam` in a process of its own and in this one."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cell.clock import SimulatedClock
from cell.twin.emulators.axis_vapix import EmulatedAxisCamera, EmulatedAxisSettings
from console.cli import main
from console.exits import Exit
from tests.console.cli import run_cell


@pytest.fixture
def camera_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_still_is_written_where_it_was_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "picture.jpg"
    result = run_cell("webcam", "still", str(file), "--size", "320x240", home=tmp_path)
    assert result.returncode == Exit.DONE, result.stderr
    assert result.stdout == f"{file}\n"
    assert file.read_bytes().startswith(b"\xff\xd8")
    assert "emulated camera" in result.stderr


def test_a_move_ends_where_the_camera_looks(
    camera_home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["webcam", "move", "--pan", "30", "--tilt", "-10", "--json"]) == Exit.DONE
    told = json.loads(capsys.readouterr().out)
    assert (told["pan_deg"], told["tilt_deg"]) == (30.0, -10.0)


def test_a_sweep_stops_by_itself(camera_home: Path) -> None:
    # The url is that of a camera of metal to the command, so it would wait in real time.
    with EmulatedAxisCamera() as emulated:
        words = ["webcam", "sweep", "50", "--seconds", "0.01", "--url", emulated.url]
        assert main(words) == Exit.DONE
        assert sum("continuouspantiltmove=0,0" in request for request in emulated.requests) == 1
        assert any("move=stop" in request for request in emulated.requests)


def test_pictures_of_a_stream_are_kept_with_progress(
    camera_home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with EmulatedAxisCamera(EmulatedAxisSettings(rate_hz=1000.0)) as emulated:
        words = ["webcam", "watch", "kept", "--frames", "5", "--size", "160x120", "--json"]
        assert main([*words, "--url", emulated.url]) == Exit.DONE
    written = sorted((camera_home / "kept").iterdir())
    assert [file.name for file in written] == [f"{number:06}.jpg" for number in range(1, 6)]
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert (told["frames"], told["broken"], told["reconnects"]) == (5, 0, 0)
    assert told["bytes"] == sum(file.stat().st_size for file in written)
    assert "5 of 5" in err


def test_every_other_command_reaches_the_camera(
    camera_home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with EmulatedAxisCamera(EmulatedAxisSettings(speed_deg_s=1e6, zoom_s=1e-6)) as emulated:
        for words, said in (
            (["info"], "AXIS 211 PTZ"),
            (["position"], "pan_deg"),
            (["step", "upleft"], "-5"),
            (["stop"], "tilt_deg"),
            (["home"], "zoom"),
            (["preset"], "table"),
            (["preset", "table"], "-40"),
            (["centre", "600", "40"], "pan_deg"),
            (["lens", "--focus", "300", "--iris", "auto", "--brightness", "8000"], "8000"),
            (["parameters", "Brand"], "root.Brand.Brand=AXIS"),
        ):
            assert main(["webcam", *words, "--url", emulated.url]) == Exit.DONE, words
            assert said in capsys.readouterr().out, words
        assert emulated.state().focus == 300


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["move", "--pan", "300"], Exit.USAGE, "allowed is -180 to 180 deg"),
        (["move"], Exit.USAGE, "give pan, tilt or zoom"),
        (["still", "--size", "big"], Exit.USAGE, "as 640x480"),
        (["lens", "--focus", "near"], Exit.USAGE, "`auto` or a number"),
        (["preset", "roof"], Exit.ENVIRONMENT, "there are: Home, table, store"),
        (["home", "--url", "192.168.0.90"], Exit.USAGE, "http://HOST"),
        (["home", "--url", "http://a:b@localhost"], Exit.USAGE, "environment variable"),
        (["home", "--profile", "lynx", "--wires", "hardware"], Exit.USAGE, "no web camera"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_cannot_be_is_one_sentence_and_a_code(
    camera_home: Path,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    code: Exit,
    message: str,
) -> None:
    assert main(["webcam", *words]) == code
    (sentence,) = (line for line in capsys.readouterr().err.splitlines() if "emulated" not in line)
    assert message in sentence


def test_the_clock_of_the_emulated_camera_makes_nobody_wait(camera_home: Path) -> None:
    with EmulatedAxisCamera(clock=SimulatedClock()) as emulated:
        assert emulated.state().pan_deg == 0.0
    assert main(["webcam", "sweep", "10", "--seconds", "60"]) == Exit.DONE
