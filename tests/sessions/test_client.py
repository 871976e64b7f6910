from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from sessions.client import ActionReply, MasClient
from sessions.errors import (
    ClientError,
    CommandRefused,
    ConnectionLost,
    LocalProtocolError,
    RemoteProtocolError,
    ReplyTimeout,
    ServerBusy,
)
from sessions.server import MasServer
from tests.sessions.fakes import FakeCell, make_desk, pixels_of
from tests.sessions.serving import serving
from tests.sessions.wire.tables import ALL, NEWER, ON_REQUEST


def client_of(server: MasServer) -> MasClient:
    address = server.addresses[0]
    return MasClient.connect(address.host, address.port, timeout_s=20.0)


@contextmanager
def answering(*replies: bytes) -> Iterator[int]:
    """Serve one connection that gets a prepared reply to each line; yield the port."""

    def serve() -> None:
        connected, _ = listening.accept()
        with connected:
            for reply in replies:
                line = b""
                while not line.endswith(b"\n"):
                    if not (byte := connected.recv(1)):
                        return
                    line += byte
                connected.sendall(reply)
            if replies[-1]:
                return
            connected.recv(1)

    with socket.create_server(("127.0.0.1", 0)) as listening:
        thread = threading.Thread(target=serve)
        thread.start()
        yield listening.getsockname()[1]
        thread.join(20)
        assert not thread.is_alive()


INFO = b"TYPE ApplicationServer\nSUBTYPE Interactive\nPROTOCOL 1.5\n"


@pytest.mark.parametrize("version", ALL)
def test_a_client_solves_a_task_in_every_dialect(version: str) -> None:
    cell = FakeCell()
    with serving(make_desk(cell), version) as server, client_of(server) as client:
        assert client.dialect.version == version
        assert client.status()
        assert client.goals() == ("Reach", "Wander")
        assert client.environments("Reach") == ("LINE", "OTHER")
        offer = client.initialize_task("Reach", "LINE")
        assert offer.actions == ("UP", "LEFT", "RIGHT")
        assert [view.name for view in offer.views] == ["CAMERA_TOP", "CAMERA_GRIPPER"]
        client.begin_setup()
        assert client.end_setup() == ("RIGHT" if version == "1.4" else "")
        hint = "RIGHT" if version == "1.4" else ""
        assert client.action("UP") == ActionReply(-10.0, "Robot hit the wall", hint)
        assert client.action("RIGHT") == ActionReply(0.0, "Robot move", hint)
        assert client.action("RIGHT") == ActionReply(0.25, "Robot move", hint)
        assert client.action("RIGHT") == ActionReply(20.0, "Target reached", "", "FINISHED")
        assert client.reset_task() == hint
        failed = client.action("LEFT")
        assert failed.state == ("FAILED" if version in ("1.3", "1.4") else "STATE_UPDATED")
    assert cell.calls[-1] == "close"


def test_views_come_as_pixels() -> None:
    with serving(make_desk(FakeCell())) as server, client_of(server) as client:
        client.start("Reach", "LINE")

        top, gripper = client.get_view("CAMERA_TOP"), client.get_view("CAMERA_GRIPPER")

        assert (top.mime, top.width_px, top.height_px) == ("image/mif", 640, 480)
        np.testing.assert_array_equal(top.pixels(), pixels_of(640, 480))
        assert (gripper.mime, len(gripper.data)) == ("image/pgm", 1228816)
        assert gripper.pixels().shape == (960, 1280, 3)


@pytest.mark.parametrize("version", ON_REQUEST)
def test_teaching_brings_suggestions(version: str) -> None:
    with serving(make_desk(FakeCell()), version) as server, client_of(server) as client:
        client.start("Reach", "LINE")
        client.teaching(is_on=True)

        assert client.action("UP").suggestion == "RIGHT"


@pytest.mark.parametrize("version", NEWER)
def test_seed_logs_and_reset(version: str) -> None:
    with serving(make_desk(FakeCell()), version) as server, client_of(server) as client:
        assert client.logs() == {}
        client.use_seed(77)
        client.start("Wander", "LINE")
        assert client.logs() == {
            "session.log": "seed 77 chosen by the client\ntask Wander LINE seed 77\n"
        }
        client.reset()
        assert client.logs() == {}
        client.sleep()
        assert not client.status()


def test_dialect_1_4_has_no_recorded_trajectories_here() -> None:
    with serving(make_desk(FakeCell()), "1.4") as server, client_of(server) as client:
        assert client.trajectories() == 0
        with pytest.raises(CommandRefused, match="UNKNOWN_TRAJECTORY 0"):
            client.trajectory_length(0)


def test_a_refusal_carries_command_and_answer() -> None:
    with serving(make_desk(FakeCell())) as server, client_of(server) as client:
        with pytest.raises(CommandRefused) as refused:
            client.action("UP")
        assert (refused.value.command, refused.value.answer) == ("ACTION UP", "NO_TASK_SELECTED")

        client.initialize_task("Reach", "LINE")
        client.begin_setup()
        with pytest.raises(CommandRefused, match="unknown setting colour"):
            client.setting("colour", "blue")
        client.end_setup()
        with pytest.raises(CommandRefused, match="UNKNOWN_ACTION 'fly away'"):
            client.action("fly away")
        assert client.action("UP").reward == -10.0


def test_a_setting_cannot_have_the_name_of_a_command() -> None:
    with (
        serving(make_desk(FakeCell())) as server,
        client_of(server) as client,
        pytest.raises(LocalProtocolError, match="DONE"),
    ):
        client.setting("DONE")


def test_a_busy_cell_is_told_and_can_be_waited_for() -> None:
    with serving(make_desk(FakeCell())) as server, client_of(server) as other:
        with client_of(server) as holder:
            holder.start("Reach", "LINE")
            assert not other.status()
            with pytest.raises(ServerBusy, match="INITIALIZE_TASK Reach LINE"):
                other.initialize_task("Reach", "LINE")

        assert other.status()
        other.start("Reach", "LINE")


def test_leaving_with_an_error_closes_without_a_word() -> None:
    with serving(make_desk(FakeCell())) as server:
        with pytest.raises(ZeroDivisionError), client_of(server) as client:
            raise ZeroDivisionError

        with pytest.raises(ConnectionLost, match="'STATUS' was not sent"):
            client.status()


def test_nobody_listening_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]

    with pytest.raises(ConnectionLost, match=f"127.0.0.1:{port}.*is the server running"):
        MasClient.connect("127.0.0.1", port)


def test_a_server_that_closes_instead_of_answering_is_told() -> None:
    with answering(INFO) as port:
        client = MasClient.connect("127.0.0.1", port, timeout_s=20)

        with pytest.raises(ConnectionLost):
            client.status()


def test_a_server_that_closes_in_the_middle_of_a_view_is_told() -> None:
    with answering(INFO, b"VIEW V image/mif 1000\nMIF") as port:
        client = MasClient.connect("127.0.0.1", port, timeout_s=20)

        with pytest.raises(ConnectionLost, match="closed the connection before"):
            client.get_view("V")


def test_a_silent_server_is_told_after_the_time_out() -> None:
    with answering(b"") as port:
        client = MasClient(socket.create_connection(("127.0.0.1", port)), timeout_s=0.05)

        with pytest.raises(ReplyTimeout, match=r"no answer to 'STATUS' within 0\.05 s"):
            client.status()
        with pytest.raises(ConnectionLost):
            client.status()


@pytest.mark.parametrize(
    ("reply", "words"),
    [
        (b"HTTP/1.1 400 Bad Request\r\n", "no reply begins with"),
        (b"TYPE A\nSUBTYPE B\nPROTOCOL 2.0\n", "MAS 2.0"),
        (b"OK\n", "'OK' to 'INFO'"),
    ],
)
def test_a_server_that_speaks_something_else_is_told(reply: bytes, words: str) -> None:
    with answering(reply) as port, pytest.raises(RemoteProtocolError, match=words):
        MasClient.connect("127.0.0.1", port, timeout_s=20)


def test_a_server_without_room_is_told_as_busy() -> None:
    with answering(b"BUSY\n") as port, pytest.raises(ServerBusy):
        MasClient.connect("127.0.0.1", port, timeout_s=20)


def test_every_error_of_a_conversation_can_be_caught_at_once() -> None:
    for kind in (ServerBusy, CommandRefused, ReplyTimeout, ConnectionLost):
        assert issubclass(kind, ClientError)
