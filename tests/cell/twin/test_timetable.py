from __future__ import annotations

from cell.twin.timetable import Timetable


def test_what_is_due_happens_while_others_sleep_in_order_and_on_time() -> None:
    timetable = Timetable()
    seen: list[tuple[str, float]] = []
    timetable.at_time(2.0, lambda now_s: seen.append(("second", now_s)))
    timetable.at_time(1.0, lambda now_s: seen.append(("first", now_s)))
    timetable.clock.sleep(0.5)
    assert seen == []
    timetable.clock.sleep(5.0)
    assert seen == [("first", 1.0), ("second", 2.0)]
    assert timetable.clock.now_s() == 5.5


def test_what_happens_may_let_more_happen() -> None:
    timetable = Timetable()
    seen: list[float] = []
    timetable.at_time(1.0, lambda now_s: timetable.at_time(now_s + 1.0, seen.append))
    timetable.clock.sleep(3.0)
    assert seen == [2.0]


def test_the_nth_request_of_a_kind_on_one_link_counts_and_replies_do_not() -> None:
    timetable = Timetable()
    seen: list[float] = []
    timetable.at_request("arm", 2, seen.append, counts=lambda data: data.startswith(b"M"))
    for link, direction, data in (
        ("arm", "to_device", b"M1"),
        ("gripper", "to_device", b"M2"),
        ("arm", "from_device", b"M3"),
        ("arm", "to_device", b"X"),
    ):
        timetable(link, direction, data)  # type: ignore[arg-type]
    assert seen == []
    timetable("arm", "to_device", b"M4")
    timetable("arm", "to_device", b"M5")
    assert len(seen) == 1
