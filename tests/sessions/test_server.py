from __future__ import annotations

import socket
import threading

import pytest

from cell.clock import SimulatedClock
from cell.profile import ServerProfile
from sessions.connection import Connection
from sessions.errors import LocalProtocolError, ServerError
from sessions.journal import SessionStart
from sessions.server import Listener, MasServer
from tests.cell.at_every_line import ends_although_interrupted
from tests.sessions.fakes import FakeCell, FakeJournal, make_desk
from tests.sessions.serving import DEADLINE_S, RawClient, serving, until_alone, until_ready

SMALL = ServerProfile(idle_timeout_s=60, max_line_bytes=4096, max_connections=2)


# Listening


MANY = 100_000


def test_ready_is_told_the_real_ports_of_all_listeners() -> None:
    told: list[tuple[Listener, ...]] = []
    listeners = [Listener("127.0.0.1", 0, version) for version in ("1.2", "1.5")]
    server = MasServer(make_desk(FakeCell()), listeners, ready=lambda a: told.append(tuple(a)))

    with server:
        assert told == [server.addresses]
        assert [address.dialect for address in server.addresses] == ["1.2", "1.5"]
        assert all(address.port > 0 for address in server.addresses)
        for address in server.addresses:
            with RawClient(server, address.dialect) as client:
                assert client.ask("INFO", 3).endswith(f"PROTOCOL {address.dialect}")


def test_a_port_in_use_is_told_and_nothing_is_left_listening() -> None:
    with serving(make_desk(FakeCell())) as server:
        taken = server.addresses[0].port
        other = MasServer(
            make_desk(FakeCell()),
            [Listener("127.0.0.1", 0, "1.5"), Listener("127.0.0.1", taken, "1.5")],
        )

        with pytest.raises(ServerError, match=f"127.0.0.1:{taken}.*in use"):
            other.start()

        assert other.addresses == ()


def test_an_unknown_dialect_is_refused() -> None:
    with pytest.raises(LocalProtocolError, match=r"1\.6"):
        MasServer(make_desk(FakeCell()), [Listener("127.0.0.1", 0, "1.6")])


def test_the_server_never_speaks_first() -> None:
    with serving(make_desk(FakeCell())) as server, RawClient(server) as client:
        client.socket.settimeout(0.05)
        with pytest.raises(TimeoutError):
            client.socket.recv(1)


# Lines


def test_pipelined_commands_are_answered_in_order() -> None:
    with serving(make_desk(FakeCell())) as server, RawClient(server) as client:
        client.send(
            b"STATUS\nINITIALIZE_TASK Reach LINE\r\n\nBEGIN_TASK_SETUP\nEND_TASK_SETUP\n"
            b"ACTION RIGHT\nGET_VIEW CAMERA_TOP\nACTION UP\nDONE\n"
        )
        head = (
            b"READY\nAVAILABLE_ACTIONS UP LEFT RIGHT\n"
            b"AVAILABLE_VIEWS CAMERA_TOP:640x480 CAMERA_GRIPPER:1280x960\nOK\nOK\n"
            b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n"
            b"VIEW CAMERA_TOP image/mif 921608\n"
        )
        tail = b"REWARD -10\nEVENT 'Robot hit the wall'\nSTATE_UPDATED\nGOODBYE\n"

        data = client.receive(len(head) + 921608 + len(tail) + 1)

        assert data[: len(head)] == head
        assert data[len(head) : len(head) + 8] == b"MIF\x01\x80\x02\xe0\x01"
        assert data[len(head) + 921608 :] == tail


def test_a_command_may_come_byte_by_byte() -> None:
    with serving(make_desk(FakeCell())) as server, RawClient(server) as client:
        for byte in b"STATUS\r\n":
            client.send(bytes([byte]))

        assert client.line() == b"READY\n"


def test_a_line_beyond_the_limit_is_answered_once_and_the_next_one_is_served() -> None:
    with serving(make_desk(FakeCell())) as server, RawClient(server) as client:
        client.send(b"A" * 100_000)
        assert client.line() == b"ERROR 'The line is longer than 4096 bytes'\n"

        client.send(b"A" * 100_000 + b"\nSTATUS\n")

        assert client.line() == b"READY\n"


def test_a_slow_reader_gets_the_whole_view() -> None:
    with serving(make_desk(FakeCell())) as server, RawClient(server) as client:
        client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
        client.to_ready()
        client.send(b"GET_VIEW CAMERA_TOP\nSTATUS\n")

        assert client.line() == b"VIEW CAMERA_TOP image/mif 921608\n"
        assert len(client.receive(921608)) == 921608
        assert client.line() == b"READY\n"


# Busy


def test_while_one_client_has_the_cell_others_get_busy_for_all_but_five_commands() -> None:
    with (
        serving(make_desk(FakeCell()), "1.3", "1.4", "1.5") as server,
        RawClient(server) as holder,
        RawClient(server, "1.3") as other,
        RawClient(server, "1.4") as third,
    ):
        assert other.ask("STATUS") == "READY"
        holder.to_ready()

        assert holder.ask("STATUS") == "READY"
        assert other.ask("STATUS") == "BUSY"
        assert other.ask("INFO", 3).endswith("PROTOCOL 1.3")
        assert other.ask("LIST_GOALS", 3).endswith("END_LIST_GOALS")
        assert other.ask("LIST_ENVIRONMENTS Reach", 3).endswith("END_LIST_ENVIRONMENTS")
        for line in (
            "INITIALIZE_TASK Reach LINE",
            "INITIALIZE_TASK No LINE",
            "BEGIN_TASK_SETUP",
            "END_TASK_SETUP",
            "TEACHING ON",
            "RESET_TASK",
            "GET_VIEW CAMERA_TOP",
            "ACTION UP",
            "SLEEP",
            "LOGS",
            "USE_GLOBAL_SEED 1",
            "RESET",
        ):
            assert other.ask(line) == "BUSY", line
        assert third.ask("GET_TRAJECTORIES_COUNT") == "BUSY"
        assert third.ask("GET_TRAJECTORY_LENGTH 0") == "BUSY"
        assert other.ask("DONE") == "GOODBYE"
        assert other.is_closed_by_server()
        assert holder.ask("ACTION RIGHT", 3).endswith("STATE_UPDATED")


@pytest.mark.parametrize("line", ["RESET", "DONE"])
def test_the_cell_is_free_and_clean_when_its_holder_is_answered(line: str) -> None:
    cell = FakeCell()
    with (
        serving(make_desk(cell)) as server,
        RawClient(server) as holder,
        RawClient(server) as other,
    ):
        holder.to_ready()
        holder.ask(line)

        assert (cell.blocks_out, cell.is_open) == (0, False)
        assert other.ask("STATUS") == "READY"
        other.to_ready()


def test_while_the_cell_is_cleaned_up_others_get_busy() -> None:
    cell = FakeCell()
    with (
        serving(make_desk(cell)) as server,
        RawClient(server) as holder,
        RawClient(server) as other,
    ):
        holder.to_ready()
        cell.gates["clean"], cell.entered["clean"] = threading.Event(), threading.Event()
        holder.socket.close()
        assert cell.entered["clean"].wait(DEADLINE_S)

        assert other.ask("STATUS") == "BUSY"
        assert other.ask("INITIALIZE_TASK Reach LINE") == "BUSY"
        cell.gates["clean"].set()

        until_ready(server)


def test_after_sleep_new_connections_get_busy_and_running_ones_go_on() -> None:
    with serving(make_desk(FakeCell())) as server, RawClient(server) as running:
        assert running.ask("SLEEP") == "OK"

        with RawClient(server) as late:
            assert late.ask("STATUS") == "BUSY"
            assert late.ask("INITIALIZE_TASK Reach LINE") == "BUSY"
            assert late.ask("LIST_GOALS", 3).endswith("END_LIST_GOALS")
        assert running.ask("STATUS") == "BUSY"
        running.to_ready()
        assert running.ask("ACTION RIGHT", 3).startswith("REWARD 0")


def test_one_connection_too_many_gets_busy_and_is_closed(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with (
        serving(make_desk(FakeCell()), limits=SMALL) as server,
        RawClient(server) as first,
        RawClient(server) as second,
    ):
        assert [first.ask("STATUS"), second.ask("STATUS")] == ["READY", "READY"]
        with RawClient(server) as third:
            assert third.ask("INFO") == "BUSY"
            assert third.is_closed_by_server()
        assert [m for m in caplog.messages if "too many" in m] != []
        first.leave()
        second.leave()
        until_alone(server)

        with RawClient(server) as fourth:
            assert fourth.ask("STATUS") == "READY"


def test_a_flood_of_connections_is_closed_without_a_word() -> None:
    with serving(make_desk(FakeCell()), limits=SMALL) as server:
        clients = [RawClient(server) for _ in range(4)]
        answers = [client.ask("STATUS") for client in clients[:2]]
        with RawClient(server) as fifth:
            assert fifth.is_closed_by_server()
        for client in clients:
            client.socket.close()

        assert answers == ["READY", "READY"]


# Going away


def test_a_client_that_vanishes_leaves_a_clean_cell(caplog: pytest.LogCaptureFixture) -> None:
    cell = FakeCell()
    journals: list[FakeJournal] = []

    def open_journal(start: SessionStart) -> FakeJournal:
        journals.append(FakeJournal(start))
        return journals[-1]

    with serving(make_desk(cell, journal_factory=open_journal)) as server:
        with RawClient(server) as client:
            client.to_ready()
        until_ready(server)

        assert cell.calls[-2:] == ["clean", "close"]
        assert journals[0].notes[-1] == ("closed", "connection closed")
        assert [m.partition(": ")[2] for m in caplog.messages] == ["connection closed, cleaning up"]


def test_closing_in_the_middle_of_a_view_harms_nobody(caplog: pytest.LogCaptureFixture) -> None:
    cell = FakeCell()
    with serving(make_desk(cell)) as server:
        with RawClient(server) as client:
            client.to_ready()
            client.send(b"GET_VIEW CAMERA_GRIPPER\n" * 8)
            assert client.line() == b"VIEW CAMERA_GRIPPER image/pgm 1228816\n"
        until_ready(server)

        assert cell.calls[-2:] == ["clean", "close"]
        assert len(caplog.messages) == 1
        assert caplog.messages[0].endswith(", cleaning up")


def test_silence_is_broken_off_after_the_idle_time_out(caplog: pytest.LogCaptureFixture) -> None:
    cell, clock = FakeCell(), SimulatedClock()
    with serving(make_desk(cell, limits=SMALL), clock=clock) as server:
        client = RawClient(server).to_ready()
        clock.sleep(59)
        server.close_idle()
        assert client.ask("STATUS") == "READY"

        clock.sleep(59)
        server.close_idle()
        client.send(b"STAT")
        clock.sleep(2)
        server.close_idle()

        assert client.is_closed_by_server()
        until_ready(server)
        assert cell.calls[-2:] == ["clean", "close"]
        assert [m.partition(": ")[2] for m in caplog.messages] == [
            "silent for too long, cleaning up"
        ]
        client.socket.close()


def test_half_a_line_and_then_silence_is_broken_off(caplog: pytest.LogCaptureFixture) -> None:
    clock = SimulatedClock()
    with serving(make_desk(FakeCell(), limits=SMALL), clock=clock) as server:
        with RawClient(server) as client:
            assert client.ask("STATUS") == "READY"
            client.send(b"STATUS\nSTAT")
            assert client.line() == b"READY\n"
            # The server may still be noting when its reply left, so time passes until it has.
            for _ in range(MANY):
                clock.sleep(61)
                server.close_idle()
                if not server.connections:
                    break
            assert client.is_closed_by_server()
        until_alone(server)

        assert [m.partition(": ")[2] for m in caplog.messages] == ["silent for too long"]
        until_ready(server)


def test_a_command_that_takes_long_is_not_idle() -> None:
    cell, clock = FakeCell(), SimulatedClock()
    cell.gates["lay_out"], cell.entered["lay_out"] = threading.Event(), threading.Event()
    with serving(make_desk(cell, limits=SMALL), clock=clock) as server, RawClient(server) as client:
        client.ask("INITIALIZE_TASK Reach LINE", 2)
        client.send(b"BEGIN_TASK_SETUP\nEND_TASK_SETUP\n")
        assert cell.entered["lay_out"].wait(DEADLINE_S)
        clock.sleep(3600)
        server.close_idle()
        cell.gates["lay_out"].set()

        assert client.receive(6) == b"OK\nOK\n"
        assert client.ask("ACTION RIGHT", 3).endswith("STATE_UPDATED")


def test_a_client_that_does_not_read_is_idle() -> None:
    cell, clock = FakeCell(), SimulatedClock()
    cell.entered["grab"] = threading.Event()
    with serving(make_desk(cell, limits=SMALL), clock=clock) as server:
        client = RawClient(server).to_ready()
        client.send(b"GET_VIEW CAMERA_GRIPPER\n" * 40)
        assert cell.entered["grab"].wait(DEADLINE_S)

        while server.connections:
            clock.sleep(61)
            server.close_idle()
            join_connections(0.01)

        assert cell.calls[-2:] == ["clean", "close"]
        client.socket.close()


def join_connections(timeout_s: float) -> None:
    for thread in threading.enumerate():
        if thread.name.startswith("mas-127"):
            thread.join(timeout_s)


# Stopping


def test_a_stop_sends_the_running_reply_and_leaves_a_clean_cell() -> None:
    cell = FakeCell()
    journals: list[FakeJournal] = []

    def open_journal(start: SessionStart) -> FakeJournal:
        journals.append(FakeJournal(start))
        return journals[-1]

    server = MasServer(
        make_desk(cell, journal_factory=open_journal), [Listener("127.0.0.1", 0, "1.5")]
    )
    server.start()
    with RawClient(server) as client, RawClient(server) as idler:
        client.to_ready()
        cell.gates["move_to"], cell.entered["move_to"] = threading.Event(), threading.Event()
        client.send(b"ACTION RIGHT\nACTION RIGHT\n")
        assert cell.entered["move_to"].wait(DEADLINE_S)

        stopper = threading.Thread(target=server.shutdown)
        stopper.start()
        assert server.wait(DEADLINE_S)
        assert idler.is_closed_by_server()
        cell.gates["move_to"].set()
        stopper.join(DEADLINE_S)

        assert not stopper.is_alive()
        assert client.receive(1000) == b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n"
        assert (cell.blocks_out, cell.is_open) == (0, False)
        assert journals[0].notes[-1] == ("closed", "server stopped")
        assert not [t for t in threading.enumerate() if t.name.startswith("mas-")]
        server.shutdown()


def test_a_client_that_does_not_read_holds_no_stop_up() -> None:
    cell = FakeCell()
    cell.entered["grab"] = threading.Event()
    server = MasServer(make_desk(cell), [Listener("127.0.0.1", 0, "1.5")])
    server.start()
    client = RawClient(server).to_ready()
    client.send(b"GET_VIEW CAMERA_GRIPPER\n" * 40)
    assert cell.entered["grab"].wait(DEADLINE_S)

    server.shutdown(peer_grace_s=0.02)

    assert cell.calls[-2:] == ["clean", "close"]
    client.socket.close()


def test_a_cell_that_hangs_is_told_by_the_stop() -> None:
    cell = FakeCell()
    server = MasServer(make_desk(cell), [Listener("127.0.0.1", 0, "1.5")])
    server.start()
    client = RawClient(server).to_ready()
    cell.gates["move_to"], cell.entered["move_to"] = threading.Event(), threading.Event()
    client.send(b"ACTION RIGHT\n")
    assert cell.entered["move_to"].wait(DEADLINE_S)

    with pytest.raises(ServerError, match="may not be clean"):
        server.shutdown(timeout_s=0.05)

    cell.gates["move_to"].set()
    server.shutdown()
    client.socket.close()


def test_request_stop_lets_wait_return() -> None:
    with serving(make_desk(FakeCell())) as server:
        assert not server.wait(0)
        server.request_stop()
        assert server.wait(0)


def test_a_stop_may_be_asked_for_within_any_moment_of_asking_and_waiting_for_one() -> None:
    with serving(make_desk(FakeCell())) as server:

        def use() -> None:
            server.request_stop()
            server.wait()

        assert ends_although_interrupted(use, server.request_stop)


def test_a_shutdown_lets_wait_return() -> None:
    with serving(make_desk(FakeCell())) as server:
        server.shutdown()
        assert server.wait(0)


def test_a_shutdown_waits_for_threads_whose_connections_have_just_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    may_end = threading.Event()
    really = MasServer._serve

    def serve_slowly(server: MasServer, connection: Connection) -> None:
        really(server, connection)
        assert may_end.wait(DEADLINE_S)

    monkeypatch.setattr(MasServer, "_serve", serve_slowly)
    server = MasServer(make_desk(FakeCell()), [Listener("127.0.0.1", 0, "1.5")])
    server.start()
    with RawClient(server) as client:
        client.leave()
    until_alone(server)
    stopper = threading.Thread(target=server.shutdown)
    stopper.start()
    assert server.wait(DEADLINE_S)
    stopper.join(0.05)
    assert stopper.is_alive()
    may_end.set()
    stopper.join(DEADLINE_S)
    assert not [t for t in threading.enumerate() if t.name.startswith("mas-")]
