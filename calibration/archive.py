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
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from calibration.errors import ArchiveError
from calibration.files import only_writer, replace, write_once
from calibration.record import CalibrationRecord
from calibration.verdict import Grade
from cell.clock import Clock, SystemClock

SHORTEST_PREFIX: Final = 4
"""Fewest digits that name a calibration."""


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
        clock: Tells how long another program that writes is waited for; real time unless
            given.
    """

    def __init__(self, folder: Path, clock: Clock | None = None) -> None:
        self._folder = folder
        self._clock = clock or SystemClock()

    @property
    def folder(self) -> Path:
        """Where the calibrations are."""
        return self._folder

    def keep(self, record: CalibrationRecord, pictures: Mapping[str, bytes]) -> str:
        """Keep a record and return its identity; it is in force unless it is BAD.

        Args:
            record: The record.
            pictures: PNG files by digest; at least those that its samples name and that are
                not kept yet.

        Raises:
            ArchiveError: The folder cannot be written, or a picture is missing.
        """
        missing = [
            sample.label
            for sample in record.samples
            if sample.picture
            and sample.picture not in pictures
            and not self._picture_path(sample.picture).exists()
        ]
        if missing:
            raise ArchiveError(f"the pictures of {', '.join(missing)} are missing")
        identity = record.identity
        with self._writing():
            chains = self._chains()
            for digest, png in pictures.items():
                write_once(self._picture_path(digest), png)
            self._write_record(identity, record.canonical())
            chain = chains.setdefault(Slot(record.kind, record.subject), [])
            if record.grade is not Grade.BAD and chain[-1:] != [identity]:
                chain.append(identity)
                self._write_chains(chains)
        return identity

    def undo(self, slot: Slot) -> str | None:
        """Take the record in force out of force; return the identity of the one before.

        Returns:
            What is in force now; None if nothing is.

        Raises:
            ArchiveError: There is none in force, or the folder cannot be written.
        """
        with self._writing():
            chains = self._chains()
            chain = chains.get(slot, [])
            if not chain:
                raise ArchiveError(f"no calibration of {slot} is in force; nothing to undo")
            chain.pop()
            if not chain:
                del chains[slot]
            self._write_chains(chains)
        return chain[-1] if chain else None

    def slots(self) -> tuple[Slot, ...]:
        """Return what has a calibration in force."""
        return tuple(sorted(self._chains(), key=str))

    def current(self) -> tuple[CalibrationRecord, ...]:
        """Return the records in force, oldest first.

        Raises:
            ArchiveError: One cannot be read.
        """
        records = [self.read(chain[-1]) for chain in self._chains().values()]
        return tuple(sorted(records, key=lambda record: record.measured_at))

    def readable(self) -> tuple[tuple[CalibrationRecord, ...], tuple[str, ...]]:
        """Return the records in force that can be read, oldest first, and what is wrong.

        A record that cannot be read leaves its slot without a calibration: the one before it
        was replaced for a reason.

        Raises:
            ArchiveError: What is in force cannot be read at all.
        """
        records, problems = [], []
        for slot, chain in self._chains().items():
            try:
                records.append(self.read(chain[-1]))
            except ArchiveError as error:
                problems.append(f"the calibration of {slot} is left out: {error}")
        return tuple(sorted(records, key=lambda record: record.measured_at)), tuple(problems)

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
        if len(prefix) < SHORTEST_PREFIX:
            raise ArchiveError(f"{prefix!r} is too short; give at least {SHORTEST_PREFIX} digits")
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
        except FileNotFoundError as error:
            raise ArchiveError(f"{path} is missing; undo it, or calibrate again") from error
        except OSError as error:
            raise ArchiveError(f"{path} cannot be read: {error.strerror or error}") from error
        except ValidationError as error:
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
            return self._picture_path(digest).read_bytes()
        except OSError as error:
            raise ArchiveError(f"picture {digest[:12]} is not in {self._folder}") from error

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Be the only one who writes; what the disk refuses is told with what it means.

        Raises:
            ArchiveError: The folder cannot be written.
        """
        try:
            with only_writer(self._folder, self._clock):
                yield
        except OSError as error:
            raise ArchiveError(
                f"{self._folder} cannot be written: {error.strerror or error}; nothing was "
                "changed of what is in force"
            ) from error

    def _write_record(self, identity: str, content: bytes) -> None:
        """Write a record unless it is there whole."""
        path = self._record_path(identity)
        if not path.exists() or path.read_bytes() != content:
            replace(path, content)

    def _picture_path(self, digest: str) -> Path:
        return self._folder / "pictures" / f"{digest}.png"

    def _record_path(self, identity: str) -> Path:
        return self._folder / "records" / f"{identity}.json"

    def _chains(self) -> dict[Slot, list[str]]:
        path = self._folder / "current.json"
        try:
            data = json.loads(path.read_bytes())
            if not isinstance(data, list):
                raise TypeError("a list is expected")
            return {
                Slot(str(entry["kind"]), str(entry["subject"])): [str(i) for i in entry["records"]]
                for entry in data
                if entry["records"]
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
            if chain
        ]
        replace(self._folder / "current.json", json.dumps(data, indent=1).encode())
