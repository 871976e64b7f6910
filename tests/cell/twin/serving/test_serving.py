"""Emulators behind ports that any program can open."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from cell.clock import SystemClock
from cell.errors import CellError, LinkError
from cell.links.base import Direction
from cell.links.serial import SerialLink
from cell.profile import SerialProfile
from cell.twin.serving.ends import PtyEnd, TcpEnd
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.server import EmulatorServer
from cell.twin.wire_faults import FaultyEmulator, WireFault
from tests.cell.links.test_memory import Echo

DEADLINE_S = 10.0


class Bench:
    """An echo served on a pseudo-terminal."""

    def __init__(self, folder: Path) -> None:
        self.line = SerialProfile(
            port=str(folder / "device"), baud=38400, parity="even", stop_bits=2
        )
        self.traffic: list[tuple[Direction, bytes]] = []
        self.device = FaultyEmulator(Echo(0.0))
        self.port = PtyPort(folder / "device", self.line, seed=3)
        self.server = EmulatorServer(
            "device", self.device, PtyEnd(self.port), SystemClock(), tap=self._note
        )

    def _note(self, link: str, direction: Direction, data: bytes) -> None:
        self.traffic.append((direction, data))

    def ask(self, word: bytes, **changes: int) -> bytes:
        link = SerialLink("device", self.line.model_copy(update=changes))
        link.write(word)
        data = b""
        while len(data) < len(word):
            piece = link.read(DEADLINE_S)
            assert piece, "no answer"
            data += piece
        link.close()
        return data


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    with made.server:
        yield made


def test_one_program_after_the_other_is_answered(bench: Bench) -> None:
    for number in range(5):
        word = b"word %d" % number
        assert bench.ask(word) == word


@pytest.mark.parametrize("changes", [{"baud": 9600}, {"stop_bits": 1}, {"baud": 115200}])
def test_a_wrong_speed_or_stop_bit_is_garbage_both_ways(
    bench: Bench, changes: dict[str, int]
) -> None:
    word = b"thirty-two bytes of a plain text"
    assert bench.ask(word, **changes) != word
    heard = b"".join(data for direction, data in bench.traffic if direction == "to_device")
    assert len(heard) == len(word)
    assert heard != word
    assert bench.ask(word) == word


def test_wrong_parity_and_data_bits_cannot_be_seen(bench: Bench) -> None:
    assert bench.ask(b"seven bits", data_bits=7) == b"seven bits"


def test_a_pulled_cable_takes_the_port_away_and_a_new_one_has_the_same_name(bench: Bench) -> None:
    link = SerialLink("device", bench.line)
    bench.device.inject(WireFault.UNPLUGGED)
    assert not Path(bench.line.port).exists()
    with pytest.raises(LinkError):
        link.read(DEADLINE_S)
    link.close()
    bench.device.clear()
    assert bench.ask(b"again") == b"again"


def test_a_stopped_server_leaves_no_port_and_no_thread(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.server.start()
    bench.server.stop()
    bench.server.stop()
    assert not bench.server.is_running
    assert list(tmp_path.iterdir()) == []


def test_a_server_that_was_never_started_can_be_stopped(tmp_path: Path) -> None:
    Bench(tmp_path).server.stop()
    assert list(tmp_path.iterdir()) == []


def test_a_port_does_not_replace_a_file(tmp_path: Path) -> None:
    (tmp_path / "device").write_text("kept")
    with pytest.raises(CellError, match="no port can be made"):
        Bench(tmp_path)
    assert (tmp_path / "device").read_text() == "kept"


def test_paced_replies_come_whole_in_the_end(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.server.stop()
    port = PtyPort(tmp_path / "device", bench.line)
    device = FaultyEmulator(Echo(0.0))
    with EmulatorServer("device", device, PtyEnd(port), SystemClock(), byte_s=0.0003):
        assert bench.ask(b"byte by byte") == b"byte by byte"


def test_a_second_program_on_tcp_is_turned_away() -> None:
    end = TcpEnd("127.0.0.1", 0)
    with EmulatorServer("device", FaultyEmulator(Echo(0.0)), end, SystemClock()):
        with socket.create_connection(("127.0.0.1", end.port), DEADLINE_S) as first:
            first.sendall(b"one")
            assert first.recv(16)
            with socket.create_connection(("127.0.0.1", end.port), DEADLINE_S) as second:
                assert second.recv(16) == b""
        with socket.create_connection(("127.0.0.1", end.port), DEADLINE_S) as third:
            third.sendall(b"three")
            assert third.recv(16)


def test_an_address_in_use_is_told() -> None:
    first = TcpEnd("127.0.0.1", 0)
    with pytest.raises(CellError, match="choose another port"):
        TcpEnd("127.0.0.1", first.port)
    first.unplug()
