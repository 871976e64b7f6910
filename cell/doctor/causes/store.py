"""What can be wrong with the store and the ledger of blocks."""

from __future__ import annotations

from cell.doctor.findings import Cause

_GROUP = "Store"

STORE: tuple[Cause, ...] = (
    Cause(
        id="ledger-unreadable",
        title="The ledger of blocks cannot be read",
        group=_GROUP,
        rank=4,
        see="Nothing that moves blocks starts.",
        why="The file is damaged, or is no ledger.",
        fix="put leftover blocks back into the store by hand, then move ledger.sqlite out of the "
        "state folder",
        found="The file is opened read-only and asked for its tables.",
        undo="move the file back",
    ),
    Cause(
        id="ledger-out-of-reach",
        title="The ledger of blocks cannot be reached",
        group=_GROUP,
        rank=6,
        see="Nothing that moves blocks starts.",
        why="The disk is full or fails, the file belongs to another user, or another program has "
        "it open; what the ledger holds is still there.",
        fix="free space, give the file to the user who runs the cell, stop the other program; "
        "keep ledger.sqlite where it is",
        found="The file is opened read-only, and SQLite tells of another error than of damage.",
    ),
    Cause(
        id="transfer-interrupted",
        title="A transfer was interrupted",
        group=_GROUP,
        rank=63,
        see="A block hangs in the fingers or stands where no one expects it.",
        why="The program or the arm was stopped while a block was on its way.",
        fix="look where the block is; then `cell clean` finishes the transfer",
        found="The ledger holds a transfer that was begun and not ended.",
    ),
    Cause(
        id="blocks-at-one-place",
        title="Two blocks are noted at one place",
        group=_GROUP,
        rank=64,
        see="Cleaning grips the wrong block, or nothing.",
        why="A block was moved by hand, or the ledger was copied from another cell.",
        fix="put these blocks into their slots by hand, then `cell clean`",
        found="Two places of the ledger are nearer to each other than blocks can lie.",
    ),
    Cause(
        id="block-unknown",
        title="A block is noted that the store does not have",
        group=_GROUP,
        rank=64,
        see="Cleaning is refused.",
        why="The script's store was changed while blocks lay out, or another script was used.",
        fix="clean with the script that laid the block out, or put it back by hand",
        found="The ledger names a slot that the store plan does not have.",
    ),
    Cause(
        id="block-out",
        title="Blocks lie out although no session runs",
        group=_GROUP,
        rank=65,
        see="Blocks lie on the playground in the morning.",
        why="The last session did not end in order.",
        fix="run `cell clean`, or put them back by hand and clean afterwards",
        found="The ledger's places outside the store while the cell is not in service.",
    ),
)
