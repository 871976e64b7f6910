"""Notes a run on disk while it goes on, so that an interrupted one can go on later.

    start.json      what the run began with: procedure, profile, store, calibrations, program
    answers.jsonl   a line for each answer: digest of the request, the answer
    <digest>.png    the pictures among the answers

A line is on disk before the procedure hears the answer. A line that was cut short by the end
of the program is as if it was never written: its request is made again.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import JsonValue, TypeAdapter, ValidationError

from calibration.errors import CalibrationError, JournalError
from calibration.files import replace, write_once
from calibration.pictures import decode_png, encode_png
from calibration.requests import Answer, Picture, Request, ToolReading
from cell.devices.camera import CameraSettings
from cell.devices.camera_features import CameraFeature
from cell.store import TablePlace

FORMAT: Final = 1

_SETTINGS: Final = TypeAdapter(CameraSettings)
_PLACE: Final = TypeAdapter(TablePlace)
_READING: Final = TypeAdapter(ToolReading)
_FEATURE: Final = TypeAdapter(CameraFeature)
_FEATURES: Final = TypeAdapter(tuple[CameraFeature, ...])


def request_digest(request: Request) -> str:
    """Return the SHA-256 of what is asked; pictures count by their pixels."""
    content = {field.name: _plain(getattr(request, field.name)) for field in fields(request)}
    text = json.dumps([type(request).__name__, content], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _plain(value: object) -> object:
    """Return a value in one fixed form; numbers that are equal come out equal."""
    if isinstance(value, Picture):
        return value.digest
    if isinstance(value, np.ndarray):
        return hashlib.sha256(repr(value.shape).encode() + value.tobytes()).hexdigest()
    if isinstance(value, bool | str) or value is None:
        return value
    if isinstance(value, int | float | np.number):
        return float(value)
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return repr(value)


class RunJournal:
    """The notes of one run.

    Args:
        folder: Where they are.
        origin: What the run depends on beside its answers, as texts by name; a run goes on
            only where all of it is as it was.
    """

    def __init__(self, folder: Path, origin: Mapping[str, str]) -> None:
        self._folder = folder
        self._origin: dict[str, str] = {"format": str(FORMAT), **origin}
        self._known: list[tuple[str, JsonValue]] = []
        self._next = 0

    @property
    def exists(self) -> bool:
        """Whether there are notes of an interrupted run."""
        return (self._folder / "start.json").exists()

    @property
    def noted(self) -> int:
        """How many whole answers are on disk."""
        try:
            return (self._folder / "answers.jsonl").read_bytes().count(b"\n")
        except OSError:
            return 0

    @property
    def interrupted_at(self) -> datetime | None:
        """When the last answer of an interrupted run was noted, None without any."""
        try:
            changed_s = (self._folder / "answers.jsonl").stat().st_mtime
        except OSError:
            return None
        return datetime.fromtimestamp(changed_s, UTC) if self.exists and self.noted else None

    @property
    def known(self) -> int:
        """How many answers an interrupted run left."""
        return len(self._known)

    def begin(self) -> None:
        """Begin with no notes; those of an earlier run are thrown away.

        Raises:
            JournalError: The folder cannot be written.
        """
        self.remove()
        try:
            replace(self._folder / "start.json", json.dumps(self._origin, indent=1).encode())
        except OSError as error:
            raise self._unwritable(error) from error

    def go_on(self) -> None:
        """Take up the notes of an interrupted run.

        Raises:
            JournalError: There are none, they are damaged, or what the run depends on has
                changed since.
        """
        path = self._folder / "start.json"
        try:
            before = json.loads(path.read_bytes())
        except FileNotFoundError as error:
            raise JournalError(
                "there is no interrupted run to go on with; start it anew"
            ) from error
        except (OSError, ValueError) as error:
            raise JournalError(f"{path} cannot be read; start the run anew") from error
        if not isinstance(before, dict):
            raise JournalError(f"{path} cannot be read; start the run anew")
        changed = [
            name for name in sorted({*before, *self._origin})
            if before.get(name) != self._origin.get(name)
        ]  # fmt: skip
        if changed:
            raise JournalError(
                f"the interrupted run cannot go on: {' and '.join(changed)} changed since it "
                "began; start it anew"
            )
        self._known = self._read()
        self._next = 0

    def recall(self, request: Request) -> tuple[Answer] | None:
        """Return the noted answer in a tuple of one, None where the notes end.

        Raises:
            JournalError: Something else was asked at this place, or a picture is damaged.
        """
        if self._next >= len(self._known):
            return None
        digest, stored = self._known[self._next]
        if digest != request_digest(request):
            raise JournalError(
                f"the interrupted run cannot go on: step {self._next + 1} asks for something "
                f"else now ({type(request).__name__}); start it anew"
            )
        self._next += 1
        return (self._answer(stored),)

    def note(self, request: Request, answer: Answer) -> None:
        """Note an answer; it is on disk when this returns.

        Raises:
            JournalError: The folder cannot be written.
        """
        try:
            stored = self._stored(answer)
            line = json.dumps([request_digest(request), stored]) + "\n"
            with (self._folder / "answers.jsonl").open("ab") as file:
                file.write(line.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise self._unwritable(error) from error

    def png(self, digest: str) -> bytes:
        """Return the file of a noted picture.

        Raises:
            JournalError: There is none.
        """
        path = self._folder / f"{digest}.png"
        try:
            return path.read_bytes()
        except OSError as error:
            raise JournalError(f"{path} cannot be read; start the run anew") from error

    def has_png(self, digest: str) -> bool:
        """Return whether a picture was noted."""
        return (self._folder / f"{digest}.png").exists()

    def remove(self) -> None:
        """Throw the notes away; harmless if there are none.

        Raises:
            JournalError: The folder cannot be written.
        """
        self._known, self._next = [], 0
        try:
            (self._folder / "start.json").unlink(missing_ok=True)
        except OSError as error:
            raise JournalError(
                f"the notes in {self._folder} cannot be thrown away: {error.strerror or error}"
            ) from error
        shutil.rmtree(self._folder, ignore_errors=True)

    def _read(self) -> list[tuple[str, JsonValue]]:
        path = self._folder / "answers.jsonl"
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            return []
        except OSError as error:
            raise JournalError(f"{path} cannot be read; start the run anew") from error
        whole, newline, _ = data.rpartition(b"\n")
        known: list[tuple[str, JsonValue]] = []
        for number, line in enumerate(whole.split(b"\n") if newline else [], 1):
            try:
                digest, stored = json.loads(line)
            except (ValueError, TypeError) as error:
                raise JournalError(f"{path}:{number} is damaged; start the run anew") from error
            known.append((str(digest), stored))
        # What follows the last whole line was cut short, and would spoil the next one.
        try:
            with path.open("r+b") as file:
                file.truncate(len(whole) + len(newline))
        except OSError as error:
            raise self._unwritable(error) from error
        return known

    def _stored(self, answer: Answer) -> JsonValue:
        """Return an answer as JSON; a picture's file is written first."""
        stored: object
        match answer:
            case None | bool() | int() | float() | str():
                return answer
            case Picture():
                path = self._folder / f"{answer.digest}.png"
                if not path.exists():
                    write_once(path, encode_png(answer.pixels))
                settings = None if answer.settings is None else _SETTINGS.dump_python(
                    answer.settings, mode="json"
                )  # fmt: skip
                stored = {
                    "picture": answer.digest, "camera": answer.camera, "settings": settings
                }  # fmt: skip
            case TablePlace():
                stored = {"place": _PLACE.dump_python(answer, mode="json")}
            case ToolReading():
                stored = {"reading": _READING.dump_python(answer, mode="json")}
            case CameraFeature():
                stored = {"feature": _FEATURE.dump_python(answer, mode="json")}
            case tuple():
                features = [one for one in answer if isinstance(one, CameraFeature)]
                if not features:
                    return [one for one in answer if isinstance(one, int | float)]
                stored = {"features": [_FEATURE.dump_python(one, mode="json") for one in features]}
        return TypeAdapter(JsonValue).validate_python(stored)

    def _answer(self, stored: JsonValue) -> Answer:
        try:
            match stored:
                case None | bool() | int() | float() | str():
                    return stored
                case list():
                    return tuple(float(one) for one in stored if isinstance(one, int | float))
                case {"picture": str(digest), "camera": str(camera), "settings": settings}:
                    return Picture(
                        camera=camera,
                        pixels=decode_png(self.png(digest), f"{digest[:12]}.png"),
                        digest=digest,
                        settings=None if settings is None else _SETTINGS.validate_python(settings),
                    )
                case {"place": place}:
                    return _PLACE.validate_python(place)
                case {"reading": reading}:
                    return _READING.validate_python(reading)
                case {"feature": feature}:
                    return _FEATURE.validate_python(feature)
                case {"features": features}:
                    return _FEATURES.validate_python(features)
        except (ValidationError, CalibrationError) as error:
            raise JournalError(
                f"an answer in {self._folder} is damaged ({error}); start the run anew"
            ) from error
        raise JournalError(f"an answer in {self._folder} is damaged; start the run anew")

    def _unwritable(self, error: OSError) -> JournalError:
        return JournalError(
            f"{self._folder} cannot be written: {error.strerror or error}; the run can be taken "
            "up again where it is when that is mended"
        )
