"""Keeps calibrations in a folder: content-addressed, atomic, each step can be undone.

    records/<identity>.json    every record that was ever kept, never changed
    pictures/<digest>.png      the pictures of their samples
    current.json               which record is in force, for each kind and subject, and the
                               ones that were before it

A record is in force from the moment that `current.json` is replaced; a program killed
before leaves at most a file that nothing points to.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from calibration.errors import ArchiveError
from calibration.record import CalibrationRecord

_SHORTEST_PREFIX = 4


@dataclass(frozen=True, slots=True)
class Slot:
    """What is calibrated: one kind of thing of one subject."""

    kind: str
    subject: str

    def __str__(self) -> str:
        return f"{self.kind} {self.subject}"


class Archive:
    """The kept calibrations of a cell.

    Args:
        folder: Where they are; made when the first one is kept.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    @property
    def folder(self) -> Path:
        """Where the calibrations are."""
        return self._folder

    def keep(self, record: CalibrationRecord, pictures: Mapping[str, bytes]) -> str:
        """Keep a record and put it in force; return its identity.

        Args:
            record: The record.
            pictures: PNG files by digest; at least those that its samples name.

        Raises:
            ArchiveError: The folder cannot be written, or a picture is missing.
        """
        missing = [s.label for s in record.samples if s.picture and s.picture not in pictures]
        if missing:
            raise ArchiveError(f"the pictures of {', '.join(missing)} are missing")
        identity = record.identity
        try:
            for digest, png in pictures.items():
                _write_once(self._folder / "pictures" / f"{digest}.png", png)
            _write_once(self._record_path(identity), record.canonical())
            chains = self._chains()
            slot = Slot(record.kind, record.subject)
            chains.setdefault(slot, []).append(identity)
            self._write_chains(chains)
        except OSError as error:
            raise self._unwritable(error) from error
        return identity

    def undo(self, slot: Slot) -> CalibrationRecord | None:
        """Take the record in force out of force; return the one that is in force now.

        Raises:
            ArchiveError: There is none in force, or the folder cannot be written.
        """
        chains = self._chains()
        chain = chains.get(slot, [])
        if not chain:
            raise ArchiveError(f"no calibration of {slot} is in force; nothing to undo")
        chain.pop()
        if not chain:
            del chains[slot]
        try:
            self._write_chains(chains)
        except OSError as error:
            raise self._unwritable(error) from error
        return self.read(chain[-1]) if chain else None

    def slots(self) -> tuple[Slot, ...]:
        """Return what has a calibration in force."""
        return tuple(sorted(self._chains(), key=str))

    def current(self) -> tuple[CalibrationRecord, ...]:
        """Return the records in force, oldest first."""
        records = [self.read(chain[-1]) for chain in self._chains().values()]
        return tuple(sorted(records, key=lambda record: record.measured_at))

    def in_force(self, slot: Slot) -> CalibrationRecord | None:
        """Return the record in force, None if there is none."""
        chain = self._chains().get(slot)
        return self.read(chain[-1]) if chain else None

    def history(self, slot: Slot) -> tuple[str, ...]:
        """Return the identities of the records of a slot that are not undone, oldest first."""
        return tuple(self._chains().get(slot, ()))

    def all(self) -> tuple[str, ...]:
        """Return the identities of every record that was ever kept."""
        folder = self._folder / "records"
        return tuple(sorted(path.stem for path in folder.glob("*.json")))

    def find(self, prefix: str) -> CalibrationRecord:
        """Return the record whose identity begins so.

        Raises:
            ArchiveError: There is none, or several, or fewer than four digits were given.
        """
        if len(prefix) < _SHORTEST_PREFIX:
            raise ArchiveError(f"{prefix!r} is too short; give at least {_SHORTEST_PREFIX} digits")
        found = [identity for identity in self.all() if identity.startswith(prefix.lower())]
        if len(found) != 1:
            what = "no calibration" if not found else f"{len(found)} calibrations"
            raise ArchiveError(f"{what} in {self._folder} begin with {prefix}")
        return self.read(found[0])

    def read(self, identity: str) -> CalibrationRecord:
        """Return a record.

        Raises:
            ArchiveError: It is missing, damaged or not what its name says.
        """
        path = self._record_path(identity)
        try:
            record = CalibrationRecord.model_validate_json(path.read_bytes())
        except (OSError, ValidationError) as error:
            raise ArchiveError(
                f"{path} does not hold a calibration; undo it, or calibrate again"
            ) from error
        if record.identity != identity:
            raise ArchiveError(f"{path} was changed after it was kept; calibrate again")
        return record

    def picture(self, digest: str) -> bytes:
        """Return the PNG file of a picture.

        Raises:
            ArchiveError: It is missing.
        """
        try:
            return (self._folder / "pictures" / f"{digest}.png").read_bytes()
        except OSError as error:
            raise ArchiveError(f"picture {digest[:12]} is not in {self._folder}") from error

    def _record_path(self, identity: str) -> Path:
        return self._folder / "records" / f"{identity}.json"

    def _chains(self) -> dict[Slot, list[str]]:
        path = self._folder / "current.json"
        try:
            data = json.loads(path.read_bytes())
            return {
                Slot(entry["kind"], entry["subject"]): [str(i) for i in entry["records"]]
                for entry in data
            }
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise ArchiveError(
                f"{path} cannot be read; move it away to begin without calibrations (the "
                "records beside it stay)"
            ) from error

    def _write_chains(self, chains: Mapping[Slot, list[str]]) -> None:
        data = [
            {"kind": slot.kind, "subject": slot.subject, "records": chain}
            for slot, chain in sorted(chains.items(), key=lambda item: str(item[0]))
        ]
        _replace(self._folder / "current.json", json.dumps(data, indent=1).encode())

    def _unwritable(self, error: OSError) -> ArchiveError:
        return ArchiveError(
            f"{self._folder} cannot be written: {error.strerror or error}; nothing was put in force"
        )


def _write_once(path: Path, data: bytes) -> None:
    if not path.exists():
        _replace(path, data)


def _replace(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    with fresh.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(fresh, path)
