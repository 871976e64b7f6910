"""`cell store plan` and `cell store read-plan` as they are called."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from calibration.pictures import encode_png
from cell.profile import load_profile
from cell.sheet import draw_sheet, lay_out, raster
from cell.store import with_calibration_object
from console.assembling import plan_of
from tests.console.cli import run_cell

PROFILE = load_profile("mash")


def test_the_plan_is_written_and_its_facts_are_told(tmp_path: Path) -> None:
    out = tmp_path / "plan.pdf"
    call = run_cell("store", "plan", "--out", str(out), "--paper", "a4", "--json", home=tmp_path)
    assert call.returncode == 0, call.stderr
    told = json.loads(call.stdout)
    assert (told["width_mm"], told["height_mm"], told["pages"]) == (547, 368, 6)
    assert [slot["slot"] for slot in told["slots"]] == list(range(1, 20))
    assert out.read_bytes().startswith(b"%PDF-1.4")
    assert "100.0 mm" in call.stderr


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (("--out", "plan.txt"), 2, ".pdf or .svg"),
        (("--out", "missing/plan.pdf"), 3, "cannot be written"),
        (("--out", "plan.svg", "--paper", "a4"), 2, "leave --paper out"),
        (("--paper", "21x29.7"), 2, "millimetres, not centimetres"),
        (("--profile", "lynx"), 2, "has no store"),
    ],
)
def test_what_cannot_be_written_is_refused_with_its_exit_code(
    words: tuple[str, ...], code: int, says: str, tmp_path: Path
) -> None:
    placed = [str(tmp_path / w) if w.startswith(("plan.", "missing")) else w for w in words]
    call = run_cell("store", "plan", *placed, home=tmp_path)
    assert call.returncode == code
    assert says in call.stderr
    assert call.stdout == ""
    assert not list(tmp_path.glob("plan.*"))


def test_a_plan_that_does_not_fit_its_sheet_writes_nothing(tmp_path: Path) -> None:
    script = tmp_path / "far.cell"
    script.write_text("store far {\n  slot 1 cube red at (5, 50)\n}\n", "utf-8")
    call = run_cell(
        "store", "plan", "--script", str(script), "--out", str(tmp_path / "x.pdf"), home=tmp_path
    )
    assert call.returncode == 1, call.stderr
    assert "slot 1" in call.stderr
    assert not (tmp_path / "x.pdf").exists()


def test_a_picture_of_the_sheet_is_read_and_one_without_it_fails(tmp_path: Path) -> None:
    plan = with_calibration_object(plan_of("mash"), PROFILE.store)
    sheet = raster(draw_sheet(lay_out(plan.slots, PROFILE.blocks)), 2.0)
    good, bad = tmp_path / "good.png", tmp_path / "bad.png"
    good.write_bytes(encode_png(sheet))
    bad.write_bytes(encode_png(sheet * 0 + 90))
    seen = run_cell("store", "read-plan", "--picture", str(good), "--json", home=tmp_path)
    assert seen.returncode == 0, seen.stderr
    told = json.loads(seen.stdout)
    assert told["markers_seen"] == list(range(told["markers"]))
    assert told["corner_mm"] is None
    assert [one["code"] for one in told["findings"]] == ["no-view"]
    none = run_cell("store", "read-plan", "--picture", str(bad), home=tmp_path)
    assert none.returncode == 1
    assert "markers is in view" in none.stderr
    lost = run_cell("store", "read-plan", "--picture", str(tmp_path / "no.png"), home=tmp_path)
    assert lost.returncode == 2
