"""`cell store clean --picture`: what it shows, plans and writes."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.console.hands import Cell, caller


@pytest.fixture
def cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Cell:
    return caller(tmp_path, monkeypatch, capsys)


def test_a_plan_is_told_as_a_table_and_as_data_and_nothing_moves(cell: Cell) -> None:
    cell("store", "deploy", "7", "500", "0", "--yaw", "20")
    table = cell("store", "clean", "--picture", "--plan")
    assert table.code == 0
    assert "red cube" in table.out
    assert "room" in table.out
    seen = cell("store", "clean", "--picture", "--plan", "--json").data()["seen"]
    assert isinstance(seen, list)
    (one,) = seen
    assert (one["turn"], one["kind"], one["colour"]) == (1, "cube", "red")
    assert one["at_mm"] == pytest.approx([500, 0], abs=3)
    assert one["grip"]["opening_mm"] > 33


def test_cleaning_tells_what_was_seen_and_writes_the_last_picture(
    cell: Cell, tmp_path: Path
) -> None:
    cell("store", "deploy", "16", "500", "100")
    out = tmp_path / "seen.png"
    said = cell("store", "clean", "--picture", "--picture-out", str(out), "--json")
    data = said.data()
    assert (said.code, data["brought_home"], data["left"]) == (0, [16], [])
    assert data["looks"] == 2
    assert "green cylinder" in said.err
    assert out.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--plan",), "add --picture"),
        (("--picture", "--picture-out", "seen.jpg"), "let the name end in .png"),
        (("--picture", "--picture-out", "nowhere/seen.png"), "does not exist"),
    ],
)
def test_a_wrong_call_is_told_before_anything_moves(
    cell: Cell, words: tuple[str, ...], says: str
) -> None:
    said = cell("store", "clean", *words)
    assert said.code == 2
    assert says in said.err
