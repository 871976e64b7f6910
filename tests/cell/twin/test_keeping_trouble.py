"""A kept world that cannot be read or written is told in a sentence, never as an errno."""

from __future__ import annotations

from pathlib import Path

import pytest

from cell.errors import StateError
from cell.twin.keeping import WorldFile
from cell.twin.keeping_devices import DevicesFile
from tests.cell.doctor.ward import mash, twin


def test_a_folder_for_a_world_is_told_before_anything_moves(tmp_path: Path) -> None:
    (tmp_path / "world.json").mkdir()
    with pytest.raises(StateError, match=r"world\.json \(Is a directory\).*move it away"):
        twin(mash(), state_folder=tmp_path)


def test_a_world_that_is_no_text_says_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "world.json").write_bytes(b"\xff\xfe")
    with pytest.raises(StateError, match=r"no text \(byte 0\); move it away"):
        twin(mash(), state_folder=tmp_path)


def test_a_world_that_cannot_be_written_says_where_and_what_to_do(tmp_path: Path) -> None:
    cell = twin(mash())
    (tmp_path / "world.json").mkdir()
    for path in (tmp_path / "world.json", tmp_path / "nowhere" / "world.json"):
        with pytest.raises(StateError, match=r"cannot be written to .*world\.json .*free space"):
            WorldFile(path).save(cell.world, 0.0)
    cell.dispose()


def test_devices_that_cannot_be_written_say_where_and_what_to_do(tmp_path: Path) -> None:
    cell = twin(mash())
    world = tmp_path / "world.json"
    file = DevicesFile(tmp_path / "devices.json", world)
    with pytest.raises(StateError, match=r"cannot be written to .*devices\.json .*free space"):
        file.save(cell.behind, 0.0)
    WorldFile(world).save(cell.world, 0.0)
    file.save(cell.behind, 0.0)
    (tmp_path / "devices.json").unlink()
    (tmp_path / "devices.json").mkdir()
    with pytest.raises(StateError, match="move away a folder that has its name"):
        file.save(cell.behind, 0.0)
    cell.dispose()
