"""How the controller is: the data of STATE and DSTATE."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.fields import whole_field

_REMEMBERED = 256
"""Polls see the same few states again and again; reading one costs more than finding it."""


class ShortState(NamedTuple):
    """Reply to DSTATE; the bits are `tables.Run` and `tables.Stop`."""

    run: int
    stop: int
    error: int
    step: str = "1"
    mechanism: str = "0"


@lru_cache(maxsize=_REMEMBERED)
def parse_short_state(data: str) -> ShortState:
    """Read the data of a DSTATE reply.

    Raises:
        GarbledMessage: The data have another layout.
    """
    try:
        status, step, mechanism = data.split(";", 2)
        run, stop, error = _status(status)
    except ValueError as problem:
        raise GarbledMessage(f"the short state reads {data[:80]!r}") from problem
    return ShortState(run, stop, error, step, mechanism)


def print_short_state(state: ShortState) -> str:
    """Return the data of a DSTATE reply."""
    run, stop, error, step, mechanism = state
    return f"{run:02X}{stop:02X}{error};{step};{mechanism}"


class FullState(NamedTuple):
    """Reply to STATE; the bits are `tables.Run` and `tables.Stop`.

    Attributes:
        program: Program loaded in the slot, empty for none.
        line: Line it stands at.
        override_percent: The override in force.
        edit: Edit status: bit 0 editing, bit 1 running, bit 2 changed.
        run: Run status.
        stop: Stop status.
        error: Number of the active alarm, 0 for none.
        step: Step it stands at.
        mechanism_mask: Mechanisms of the slot.
        slot_program: Program of the slot table.
        is_cyclic: Whether the slot runs one cycle instead of repeating.
        start: `START`, `ALWAYS` or `ERROR`.
        priority: 1 to 31.
        mechanism: Number of the mechanism the slot moves now, 0 for none.
    """

    program: str
    line: str
    override_percent: int
    edit: int
    run: int
    stop: int
    error: int
    step: str
    mechanism_mask: int
    slot_program: str
    is_cyclic: bool
    start: str
    priority: str
    mechanism: str


@lru_cache(maxsize=_REMEMBERED)
def parse_full_state(data: str) -> FullState:
    """Read the data of a STATE reply.

    Raises:
        GarbledMessage: The data have another layout.
    """
    fields = data.split(";")
    try:
        program, line, override, edit, status, step, mask = fields[:7]
        slot_program, mode, start, priority, mechanism = fields[14:19]
        run, stop, error = _status(status)
        if mode not in {"REP", "CYC"}:
            raise ValueError
        return FullState(
            program,
            line,
            int(override),
            int(edit, 16),
            run,
            stop,
            error,
            step,
            int(mask, 16),
            slot_program,
            mode == "CYC",
            start,
            priority,
            mechanism,
        )
    except ValueError as problem:
        raise GarbledMessage(f"the state reads {data[:120]!r}") from problem


@lru_cache(maxsize=_REMEMBERED)
def print_full_state(state: FullState) -> str:
    """Return the data of a STATE reply."""
    return ";".join(
        [
            state.program,
            state.line,
            str(state.override_percent),
            f"{state.edit:02X}",
            f"{state.run:02X}{state.stop:02X}{state.error}",
            state.step,
            f"{state.mechanism_mask:02X}",
            *[""] * 7,
            state.slot_program,
            "CYC" if state.is_cyclic else "REP",
            state.start,
            state.priority,
            state.mechanism,
        ]
    )


def _status(field: str) -> tuple[int, int, int]:
    """Return run status, stop status and error of the joined field `A1060`."""
    return int(field[0:2], 16), int(field[2:4], 16), whole_field(field[4:])
