import os
from pathlib import Path

import pytest

from cell.errors import StillHeld
from cell.lock import CellLock


def test_a_held_cell_is_refused_and_names_the_holder(tmp_path: Path) -> None:
    lock = CellLock(tmp_path)
    with pytest.raises(StillHeld, match=f"process {os.getpid()}"):
        CellLock(tmp_path)
    lock.release()
    CellLock(tmp_path).release()
