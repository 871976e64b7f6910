"""What no import contract can say about the house."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import cell

ROOT = Path(__file__).parents[2]
PACKAGES = ("cell", "calibration", "dsl", "sessions", "console")
MOST_LINES = 600


def modules() -> list[Path]:
    return sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def test_the_packages_on_disk_are_those_of_the_contract() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    found = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"tests", "benchmarks"}
    assert found == set(PACKAGES) == set(config["tool"]["importlinter"]["root_packages"])


def test_the_package_named_cell_is_ours() -> None:
    assert Path(str(cell.__file__)).parent == ROOT / "cell"


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(ROOT)))
def test_a_module_keeps_to_one_concept_in_size(path: Path) -> None:
    lines = path.read_text("utf-8").count("\n")
    assert lines <= MOST_LINES, f"{path.name} has {lines} lines; split it"


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(ROOT)))
def test_nothing_below_the_console_prints_or_asks(path: Path) -> None:
    if path.is_relative_to(ROOT / "console"):
        return
    calls = {
        node.func.id
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not calls & {"print", "input"}


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("dsl.compiler", ("numpy", "cv2", "pydantic", "mcap")),
        ("console.cli", ("numpy", "cv2", "pydantic", "mcap", "lark")),
    ],
)
def test_a_light_module_loads_nothing_heavy(module: str, heavy: tuple[str, ...]) -> None:
    code = f"import {module}, sys; print(*sorted(set(sys.modules) & set({heavy!r})))"
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert run.stdout.strip() == ""


def test_every_own_error_stands_in_its_package_tree() -> None:
    for package, base in (
        ("cell", "CellError"),
        ("calibration", "CalibrationError"),
        ("dsl", "DslError"),
        ("sessions", "SessionsError"),
    ):
        names = {base}
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if not isinstance(node, ast.ClassDef):
                    continue
                bases = {b.id for b in node.bases if isinstance(b, ast.Name)}
                is_stray = bool(bases & {"Exception", "ValueError", "RuntimeError"})
                assert node.name == base or not is_stray, f"{path}: {node.name} is outside {base}"
                if bases & names:
                    names.add(node.name)


def test_the_repository_names_no_index_and_no_machine() -> None:
    for name in ("requirements.lock", "requirements-dev.lock"):
        for line in (ROOT / name).read_text("utf-8").splitlines():
            assert line.count("==") == 1, f"{name}: {line!r} is not name==version"
            assert "/" not in line
            assert ":" not in line
