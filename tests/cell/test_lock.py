import errno
import os
from pathlib import Path

import pytest

from cell.errors import StateError, StillHeld
from cell.lock import CellLock


def test_a_held_cell_is_refused_and_names_the_holder(tmp_path: Path) -> None:
    lock = CellLock(tmp_path)
    with pytest.raises(StillHeld, match=f"process {os.getpid()}"):
        CellLock(tmp_path)
    lock.release()
    CellLock(tmp_path).release()


def test_a_file_for_a_state_folder_is_told_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "mash").write_text("a file")
    for folder in (tmp_path / "mash", tmp_path / "mash" / "cell"):
        with pytest.raises(StateError, match=f"state folder {folder} .*XDG_STATE_HOME"):
            CellLock(folder)


def test_a_lock_that_cannot_be_opened_is_told_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "lock").mkdir()
    with pytest.raises(StateError, match="give it to the user"):
        CellLock(tmp_path)


def test_a_folder_without_room_or_locks_is_told_with_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(file: object, how: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("cell.lock.fcntl.flock", refuse)
    with pytest.raises(StateError, match="No locks available"):
        CellLock(tmp_path)


def test_a_full_disk_does_not_keep_the_lock_from_being_taken() -> None:
    full = Path("/dev/full")
    assert full.exists()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "mkdir", lambda *_, **__: None)
        patch.setattr(Path, "__truediv__", lambda *_: full)
        CellLock(Path("/dev")).release()
