from __future__ import annotations

import threading

from sessions.seeds import SeedSequence, derive_seed, random_seed
from tests.sessions.fakes import FakeCell, make_desk


def test_the_cell_has_one_holder_at_a_time() -> None:
    desk = make_desk(FakeCell())
    first, second = object(), object()

    assert desk.take(first)
    assert desk.take(first)
    assert not desk.take(second)
    assert desk.is_taken_from(second)
    assert not desk.is_taken_from(first)


def test_only_the_holder_can_give_the_cell_back() -> None:
    desk = make_desk(FakeCell())
    first, second = object(), object()
    desk.take(first)

    desk.give_back(second)
    assert desk.is_taken

    desk.give_back(first)
    assert desk.take(second)


def test_of_many_who_grab_for_it_one_gets_it() -> None:
    desk = make_desk(FakeCell())
    barrier = threading.Barrier(8)
    winners: list[object] = []

    def grab() -> None:
        me = object()
        barrier.wait(20)
        if desk.take(me):
            winners.append(me)

    threads = [threading.Thread(target=grab) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)

    assert len(winners) == 1


def test_the_first_session_has_the_servers_seed_and_the_others_follow_from_it() -> None:
    seeds, again, other = SeedSequence(9), SeedSequence(9), SeedSequence(10)

    told = [seeds.next_seed() for _ in range(100)]

    assert told[0] == 9
    assert told == [again.next_seed() for _ in range(100)]
    assert len(set(told)) == 100
    assert not set(told) & {other.next_seed() for _ in range(100)}
    assert all(0 <= seed < 2**32 for seed in told)


def test_seeds_of_sessions_and_of_tasks_do_not_meet() -> None:
    sessions = {derive_seed(9, "session", n) for n in range(1, 100)}

    assert not sessions & {derive_seed(9, "task", n) for n in range(1, 100)}


def test_a_random_seed_can_be_given_by_a_client() -> None:
    assert 0 <= random_seed() < 2**32
