"""Kept calibrations survive whatever happens to the program and the disk."""

from __future__ import annotations

import errno
import json
import multiprocessing
import os
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import pytest

from calibration.archive import Archive, Slot
from calibration.errors import ArchiveError
from calibration.files import only_writer
from calibration.record import CalibrationRecord
from calibration.verdict import Grade
from cell.clock import SimulatedClock
from tests.calibration.records import WHEN, a_record

TOP = Slot("homography", "top")


class Killed(BaseException):
    """Ends the program in the middle, as SIGKILL would."""


def kill_before(monkeypatch: pytest.MonkeyPatch, nth: int) -> Callable[[], int]:
    """Have the nth operation on a file end the program; return what counts them."""
    count = 0

    def counted(real: Callable[..., object]) -> Callable[..., object]:
        def operation(*arguments: object, **named: object) -> object:
            nonlocal count
            count += 1
            if count == nth:
                raise Killed
            return real(*arguments, **named)

        return operation

    for name in ("replace", "fsync", "open"):
        monkeypatch.setattr(os, name, counted(getattr(os, name)))
    for name in ("open", "mkdir"):
        monkeypatch.setattr(Path, name, counted(getattr(Path, name)))
    return lambda: count


def in_force(folder: Path) -> CalibrationRecord | None:
    return Archive(folder).in_force(TOP)


def test_a_kept_record_is_in_force_and_reads_back_the_same(tmp_path: Path) -> None:
    record = a_record(picture="ab" * 32)
    identity = Archive(tmp_path).keep(record, {"ab" * 32: b"png"})
    again = Archive(tmp_path).find(identity[:4])
    assert again == record
    assert again.identity == identity
    assert Archive(tmp_path).current() == (record,)
    assert Archive(tmp_path).picture("ab" * 32) == b"png"


def test_the_identity_follows_the_content() -> None:
    assert a_record().identity == a_record().identity
    assert a_record().identity != a_record(held_out_mm=0.8).identity
    assert a_record().identity != a_record(measured_at=WHEN + timedelta(microseconds=1)).identity


def test_a_record_keeps_its_identity_when_later_programs_add_fields() -> None:
    record = a_record(held_out_mm=0.8)
    data = json.loads(record.canonical())
    assert set(data) == set(CalibrationRecord.model_fields)
    for part, field in (
        (data, "stands_on"),
        (data, "details"),
        (data["accuracy"], "predicted_max"),
    ):
        del part[field]
    older = CalibrationRecord.model_validate(data)
    assert json.loads(older.canonical()) == data
    again = CalibrationRecord.model_validate_json(older.canonical())
    assert again.identity == older.identity != record.identity


def test_a_time_without_a_zone_is_refused() -> None:
    with pytest.raises(ValueError, match="time zone"):
        a_record(measured_at=WHEN.replace(tzinfo=None))


def test_a_figure_that_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        a_record(held_out_mm=float("nan"))


def test_killed_between_any_two_operations_the_old_or_the_new_is_in_force(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old, new = a_record(), a_record(held_out_mm=0.2, picture="cd" * 32)
    endings = []
    for nth in range(1, 100):
        folder = tmp_path / str(nth)
        Archive(folder).keep(old, {})
        with monkeypatch.context() as patch:
            counted = kill_before(patch, nth)
            try:
                Archive(folder).keep(new, {"cd" * 32: b"png"})
            except Killed:
                pass
            else:
                assert counted() < nth
                break
        found = in_force(folder)
        assert found in (old, new)
        endings.append(found == new)
        if found == new:
            assert Archive(folder).picture("cd" * 32) == b"png"
        # Whatever was left half done does not keep the next one from being kept.
        Archive(folder).keep(new, {"cd" * 32: b"png"})
        assert in_force(folder) == new
        assert Archive(folder).history(TOP) in ((old.identity, new.identity),)
    assert len(endings) > 10
    assert {True, False} == set(endings)


def test_undo_killed_between_any_two_operations_leaves_one_of_both(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old, new = a_record(), a_record(held_out_mm=0.2)
    for nth in range(1, 100):
        folder = tmp_path / str(nth)
        Archive(folder).keep(old, {})
        Archive(folder).keep(new, {})
        with monkeypatch.context() as patch:
            kill_before(patch, nth)
            try:
                Archive(folder).undo(TOP)
            except Killed:
                pass
            else:
                break
        assert in_force(folder) in (old, new)
    assert nth > 4


def test_undo_goes_back_step_by_step(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    first, second = archive.keep(a_record(), {}), archive.keep(a_record(held_out_mm=0.1), {})
    assert archive.history(TOP) == (first, second)
    assert archive.undo(TOP) == first
    assert archive.undo(TOP) is None
    assert archive.slots() == ()
    assert set(archive.all()) == {first, second}
    with pytest.raises(ArchiveError, match="nothing to undo"):
        archive.undo(TOP)


def test_a_bad_one_is_kept_but_what_was_in_force_stays(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    good = a_record()
    archive.keep(good, {})
    bad = archive.keep(a_record(grade=Grade.BAD), {})
    assert in_force(tmp_path) == good
    assert archive.find(bad).grade is Grade.BAD


def test_a_bad_first_one_puts_nothing_in_force(tmp_path: Path) -> None:
    Archive(tmp_path).keep(a_record(grade=Grade.BAD), {})
    assert Archive(tmp_path).slots() == ()


def test_a_record_without_its_pictures_is_refused_before_anything_is_written(
    tmp_path: Path,
) -> None:
    with pytest.raises(ArchiveError, match="pictures of one are missing"):
        Archive(tmp_path / "new").keep(a_record(picture="ab" * 32), {})
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("damage", [b"", b"{", b"null", b"\xff\xfe", b'{"kind": 3}'])
def test_a_damaged_record_is_told_and_the_others_still_count(tmp_path: Path, damage: bytes) -> None:
    archive = Archive(tmp_path)
    broken = archive.keep(a_record(), {})
    sound = a_record(kind="lattice", subject="cell", values={})
    archive.keep(sound, {})
    (tmp_path / "records" / f"{broken}.json").write_bytes(damage)
    with pytest.raises(ArchiveError, match="does not hold a calibration"):
        archive.current()
    records, problems = archive.readable()
    assert records == (sound,)
    assert len(problems) == 1
    assert "homography top" in problems[0]
    assert archive.undo(TOP) is None


def test_a_record_changed_by_hand_is_found_out(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    identity = archive.keep(a_record(), {})
    path = tmp_path / "records" / f"{identity}.json"
    path.write_bytes(path.read_bytes().replace(b"0.7", b"0.1"))
    with pytest.raises(ArchiveError, match="was changed after it was kept"):
        archive.read(identity)


@pytest.mark.parametrize("damage", ["", "[", "{}", "[3]", '[{"kind": "x"}]', "null"])
def test_a_damaged_list_of_what_is_in_force_is_told_and_never_overwritten(
    tmp_path: Path, damage: str
) -> None:
    archive = Archive(tmp_path)
    archive.keep(a_record(), {})
    (tmp_path / "current.json").write_text(damage)
    with pytest.raises(ArchiveError, match="move it away"):
        archive.keep(a_record(held_out_mm=0.1), {})
    assert (tmp_path / "current.json").read_text() == damage


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EIO])
def test_a_disk_that_refuses_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    old = a_record()
    Archive(tmp_path).keep(old, {})

    def refuse(descriptor: int) -> None:
        raise OSError(code, os.strerror(code))

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", refuse)
        with pytest.raises(ArchiveError, match=f"cannot be written: {os.strerror(code)}"):
            Archive(tmp_path).keep(a_record(held_out_mm=0.1), {})
        with pytest.raises(ArchiveError, match="nothing was changed"):
            Archive(tmp_path).undo(TOP)
    assert in_force(tmp_path) == old
    assert [p.name for p in tmp_path.rglob(".*") if p.name != ".lock"] == []


def test_a_folder_that_is_a_file_is_told(tmp_path: Path) -> None:
    (tmp_path / "calibrations").write_text("")
    with pytest.raises(ArchiveError, match="cannot be written"):
        Archive(tmp_path / "calibrations").keep(a_record(), {})


def test_another_writer_is_waited_for_and_then_named(tmp_path: Path) -> None:
    clock = SimulatedClock()
    named = pytest.raises(ArchiveError, match=f"written by process {os.getpid()}")
    with only_writer(tmp_path, clock), named:
        Archive(tmp_path, clock).keep(a_record(), {})
    assert clock.now_s() == pytest.approx(10.0, abs=0.1)
    Archive(tmp_path, clock).keep(a_record(), {})


def _keep_ten(folder: Path, first: int) -> None:
    for i in range(first, first + 10):
        Archive(folder).keep(a_record(held_out_mm=1.0 + i), {})


def test_two_programs_that_keep_at_once_lose_nothing(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    both = [context.Process(target=_keep_ten, args=(tmp_path, n)) for n in (0, 100)]
    for process in both:
        process.start()
    for process in both:
        process.join(60)
        assert process.exitcode == 0
    assert len(Archive(tmp_path).history(TOP)) == 20
    assert len(json.loads((tmp_path / "current.json").read_text())) == 1


@pytest.mark.parametrize("prefix", ["", "abc"])
def test_too_short_a_name_is_refused(tmp_path: Path, prefix: str) -> None:
    with pytest.raises(ArchiveError, match="too short"):
        Archive(tmp_path).find(prefix)


def test_a_record_whose_file_is_gone_is_missing_not_damaged(tmp_path: Path) -> None:
    with pytest.raises(ArchiveError, match="is missing; undo it, or calibrate again"):
        Archive(tmp_path).read("ab" * 32)
