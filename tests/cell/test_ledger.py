from pathlib import Path

import pytest

from cell.errors import LedgerError
from cell.ledger import Ledger, Transfer
from cell.store import TablePlace

THERE = TablePlace(x_mm=500.0, y_mm=-45.0, yaw_deg=0.0)


def test_a_new_ledger_has_every_block_at_home() -> None:
    ledger = Ledger(None)
    assert ledger.blocks_out() == {}
    assert ledger.open_transfer() is None


def test_a_released_block_is_out_until_it_is_home_again() -> None:
    ledger = Ledger(None)
    ledger.plan(7, None, THERE)
    ledger.gripped()
    ledger.released(7, THERE)
    assert ledger.blocks_out() == {7: THERE}
    assert ledger.open_transfer() is None
    ledger.plan(7, THERE, None)
    ledger.gripped()
    ledger.released(7, None)
    assert ledger.blocks_out() == {}


@pytest.mark.parametrize("is_gripped", [False, True])
def test_another_process_finds_the_open_transfer_in_its_phase(
    tmp_path: Path, is_gripped: bool
) -> None:
    first = Ledger(tmp_path / "ledger.sqlite")
    first.plan(16, None, THERE)
    if is_gripped:
        first.gripped()
    second = Ledger(tmp_path / "ledger.sqlite")
    assert second.open_transfer() == Transfer(
        slot=16, source=None, target=THERE, phase="gripped" if is_gripped else "planned"
    )


def test_an_abandoned_transfer_leaves_the_block_where_it_was(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    ledger.plan(7, None, THERE)
    ledger.released(7, THERE)
    ledger.plan(7, THERE, None)
    ledger.abandon()
    assert ledger.blocks_out() == {7: THERE}
    assert ledger.open_transfer() is None


def test_a_file_that_is_no_ledger_is_refused_with_advice(tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    path.write_bytes(b"not a database at all, but long enough to be looked at" * 40)
    with pytest.raises(LedgerError, match=r"cannot be opened.*move the file away"):
        Ledger(path)


def test_a_closed_ledger_says_so_instead_of_losing_an_entry() -> None:
    ledger = Ledger(None)
    ledger.close()
    with pytest.raises(LedgerError, match="cannot be used"):
        ledger.plan(1, None, THERE)
