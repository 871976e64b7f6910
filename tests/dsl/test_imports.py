from __future__ import annotations

import subprocess
import sys

import pytest


def loaded_by(statement: str) -> set[str]:
    """Return the modules that a fresh interpreter has after a statement."""
    code = f"import sys\n{statement}\nprint(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return set(done.stdout.split())


@pytest.mark.parametrize(
    "module", ["compiler", "interpreter", "render", "site", "library", "errors", "host"]
)
def test_the_language_loads_no_arrays_pictures_or_devices(module: str) -> None:
    loaded = loaded_by(f"import dsl.{module}")
    assert f"dsl.{module}" in loaded
    assert not loaded & {"numpy", "cv2", "serial", "pydantic", "cell", "sessions", "calibration"}


@pytest.mark.parametrize("module", ["compiler", "interpreter", "site"])
def test_lark_is_loaded_only_when_a_script_is_parsed(module: str) -> None:
    assert "lark" not in loaded_by(f"import dsl.{module}")


def test_running_a_script_loads_lark_and_no_arrays() -> None:
    loaded = loaded_by(
        "from dsl.compiler import compile_script\nfrom dsl.library import library_script\n"
        "assert compile_script(library_script('mash'), 'mash').program"
    )
    assert "lark" in loaded
    assert not loaded & {"numpy", "cv2", "cell"}
