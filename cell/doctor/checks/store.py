"""The ledger: what lies out, twice, or half way."""

from __future__ import annotations

import math
import sqlite3
from itertools import combinations

from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.errors import LedgerError
from cell.kept_database import is_damaged


def check_store(patient: Patient, notes: Notes) -> None:
    """Read the ledger and hold it against the plan and against itself."""
    ledger = patient.ledger
    if ledger is None:
        notes.skip("store", "whereabouts of the blocks", "the ledger could not be opened")
        return
    try:
        out, transfer = ledger.blocks_out(), ledger.open_transfer()
    except LedgerError as error:
        cause = "ledger-unreadable" if _is_damaged(error) else "ledger-out-of-reach"
        notes.find(cause, "store", "the ledger cannot be read", str(error))
        return
    if transfer is not None and not patient.is_in_service:
        problem = f"the transfer of the block of slot {transfer.slot} was interrupted"
        notes.find("transfer-interrupted", "store", problem, f"phase {transfer.phase}")
    known = {slot.number for slot in patient.plan.slots}
    for number in sorted(set(out) - known):
        problem = f"a block of slot {number} lies out, and the store has no such slot"
        notes.find("block-unknown", "store", problem, f"slots: {len(known)}")
    least_mm = min(block.width_mm for block in patient.profile.blocks.values())
    for (first, here), (second, there) in combinations(sorted(out.items()), 2):
        distance_mm = math.hypot(here.x_mm - there.x_mm, here.y_mm - there.y_mm)
        if distance_mm < least_mm / 2:
            problem = f"the blocks of slots {first} and {second} are noted at one place"
            fact = f"{distance_mm:.1f} mm apart at ({here.x_mm:.1f}, {here.y_mm:.1f}) mm"
            notes.find("blocks-at-one-place", "store", problem, fact)
    if out and not patient.is_in_service:
        numbers = ", ".join(str(number) for number in sorted(out))
        problem = "blocks lie out of the store although no session runs"
        notes.find("block-out", "store", problem, f"{len(out)} blocks out: slots {numbers}")
    elif not out and transfer is None:
        notes.fine("store", "every block is in its slot")


def _is_damaged(error: LedgerError) -> bool:
    """Return whether the file itself is at fault."""
    cause = error.__cause__
    return isinstance(cause, sqlite3.Error) and is_damaged(cause)
