from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from console.commands import COMMANDS
from tests.console.cli import REPOSITORY, environment, run_cell


def test_help_lists_every_command_on_stdout(tmp_path: Path) -> None:
    done = run_cell("--help", home=tmp_path)
    assert done.returncode == 0
    assert done.stderr == ""
    for command in COMMANDS:
        assert f"\n  {command.name}" in done.stdout


@pytest.mark.parametrize("name", [command.name for command in COMMANDS])
def test_every_command_has_help_of_its_own(name: str, tmp_path: Path) -> None:
    done = run_cell(name, "--help", home=tmp_path)
    assert done.returncode == 0
    assert done.stdout.startswith(f"Usage: cell {name}")
    assert done.stderr == ""


def test_help_imports_nothing_heavy(tmp_path: Path) -> None:
    code = (
        "import sys; from console.cli import main; main(['--help']); "
        "heavy = {'numpy', 'cv2', 'pydantic', 'mcap', 'lark', 'cyclopts', 'rich'}; "
        "sys.exit(sorted(heavy & set(sys.modules)) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment(tmp_path),
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_help_of_a_command_imports_neither_arrays_nor_pictures(tmp_path: Path) -> None:
    code = (
        "import sys; from console.cli import main; main(['serve', '--help']); "
        "sys.exit(sorted({'numpy', 'cv2', 'mcap', 'lark'} & set(sys.modules)) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment(tmp_path),
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_the_version_is_told(tmp_path: Path) -> None:
    done = run_cell("--version", home=tmp_path)
    assert done.returncode == 0
    assert done.stdout.startswith("robocell ")


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ((), ""),
        (("nonsense",), "nonsense"),
        (("check",), "SCRIPT"),
        (("check", "mash", "--nonsense"), "--nonsense"),
        (("serve", "mash", "--port", "many"), "many"),
        (("serve", "mash", "--listen", "127.0.0.1:0"), "HOST:PORT/DIALECT"),
        (("serve", "mash", "--dialect", "1.6"), "1.6"),
        (("check", "missing.cell"), "missing.cell"),
        (("check", "mash", "--profile", "nope"), "nope"),
        (("profile", "show", "nope"), "nope"),
        (("sessions", "show", "nothing"), "cell demo"),
        (("sessions", "verify", "gone.mcap"), "gone.mcap"),
        (("play", "here"), "HOST:PORT"),
        (("experiment", "127.0.0.1:1", "--policy", "wise"), "wise"),
        (("experiment", "127.0.0.1:1", "--episodes", "0"), "--episodes"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_wrong_usage_is_a_sentence_and_exit_code_2(
    words: tuple[str, ...], hint: str, tmp_path: Path
) -> None:
    done = run_cell(*words, home=tmp_path)
    assert done.returncode == 2, done.stderr
    assert hint in done.stderr
    assert "Traceback" not in done.stderr


def test_no_server_is_a_sentence_and_exit_code_3(tmp_path: Path) -> None:
    done = run_cell("experiment", "127.0.0.1:1", home=tmp_path)
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    assert "127.0.0.1:1" in done.stderr


def test_colour_stays_out_of_pipes(tmp_path: Path) -> None:
    bad = tmp_path / "bad.cell"
    bad.write_text("goal {", "utf-8")
    done = run_cell("check", str(bad), home=tmp_path)
    assert done.returncode == 1
    assert "\x1b" not in done.stdout + done.stderr


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    code = "from console.cli import main; import sys; sys.exit(main(['profile', 'show', '--json']))"
    shell = f'{sys.executable} -c "{code}" | head -1; echo ${{PIPESTATUS[0]}}'
    done = subprocess.run(
        ["bash", "-c", shell],
        env=environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stderr == ""
    assert done.stdout.splitlines()[0] == "{"
    assert done.stdout.splitlines()[-1] in ("0", "141")
