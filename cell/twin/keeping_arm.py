"""A file that keeps the twin of an arm without a playground from one process to the next.

Hardware stays where it is, and its controller powered, when a program ends; so does its twin.
A twin without a file has a controller that was just switched on.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final, TypeAlias

from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from cell.errors import CellError
from cell.twin.emulators.ibm7545 import KeptSlave, RegisterBridge
from cell.twin.emulators.ssc32 import KeptController, Ssc32Controller

ArmEmulator: TypeAlias = RegisterBridge | Ssc32Controller

_FORMAT: Final = 1
_EVERY_S: Final = 0.25


@dataclass(frozen=True, kw_only=True)
class KeptArm:
    """The fields of the file; only the arm's own device is not None."""

    format: int
    ibm7545: KeptSlave | None = None
    ssc32: KeptController | None = None


_ADAPTER: TypeAdapter[KeptArm] = TypeAdapter(KeptArm)


class ArmFile:
    """Keeps an arm's emulator in a file, written anew as a whole.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def load_into(self, emulator: ArmEmulator) -> None:
        """Put the emulator into the kept state; without a file it stays freshly powered.

        Raises:
            CellError: The file cannot be read, or holds no such arm.
        """
        if not self._path.is_file():
            return
        try:
            kept = _ADAPTER.validate_json(self._path.read_bytes())
        except (OSError, ValidationError) as error:
            raise self._useless("does not hold an arm of the twin") from error
        if kept.format != _FORMAT:
            raise self._useless(f"has format {kept.format}; this version reads {_FORMAT}")
        if isinstance(emulator, RegisterBridge) and kept.ibm7545 is not None:
            emulator.slave.restore(kept.ibm7545)
        elif isinstance(emulator, Ssc32Controller) and kept.ssc32 is not None:
            emulator.restore(kept.ssc32)
        else:
            raise self._useless("holds another arm")

    def save(self, emulator: ArmEmulator, now_s: float) -> None:
        """Write the emulator; a reader finds the old text or the new one, never a part."""
        if isinstance(emulator, RegisterBridge):
            kept = KeptArm(format=_FORMAT, ibm7545=emulator.slave.kept(now_s))
        else:
            kept = KeptArm(format=_FORMAT, ssc32=emulator.kept(now_s))
        fresh = self._path.with_suffix(".new")
        fresh.write_bytes(_ADAPTER.dump_json(kept))
        os.replace(fresh, self._path)

    def _useless(self, why: str) -> CellError:
        return CellError(f"{self._path} {why}; remove it to start with a freshly powered arm")


class KeptEmulator:
    """An emulator that is kept while it works, so that a killed process loses little.

    Args:
        emulator: The emulator.
        file: Where it is kept.
    """

    def __init__(self, emulator: ArmEmulator, file: ArmFile) -> None:
        self._emulator = emulator
        self._file = file
        self._saved_s: float | None = None

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`."""
        self._emulator.receive(data, now_s)
        if self._saved_s is None or now_s - self._saved_s >= _EVERY_S:
            self._saved_s = now_s
            self._file.save(self._emulator, now_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""
        return self._emulator.transmit(now_s)

    def next_output_s(self) -> float | None:
        """Return when the next bytes will be out, or None if none are coming."""
        return self._emulator.next_output_s()
