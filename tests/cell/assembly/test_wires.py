"""The same cell over every kind of wire."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cell.assembly import assemble_hardware, assemble_twin
from cell.assembly.models import emulate_cell, emulate_model
from cell.assembly.wires import TcpFraming, TwinWires
from cell.clock import SimulatedClock, SystemClock
from cell.errors import LinkError
from cell.links.base import Direction
from cell.profile import Profile, TcpProfile, load_profile
from cell.store import StorePlan
from cell.twin.serving.ends import PtyEnd, TcpEnd
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.server import EmulatorServer
from cell.twin.wire_faults import WireFault

PLAN = StorePlan(())
Traffic = list[tuple[str, Direction, bytes]]


class BareScreen:
    """A screen that shows nothing."""

    def __init__(self) -> None:
        self._shown = ""

    def show(self, picture: str) -> None:
        self._shown = picture

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        self._shown = name

    def shown(self) -> str:
        return self._shown

    def bookmark(self) -> Callable[[], None]:
        name = self._shown
        return lambda: self.show(name)


def _opened_and_closed(wires: TwinWires) -> tuple[dict[tuple[str, Direction], bytes], float]:
    """Return all bytes of each wire and direction, and the time that passed."""
    traffic: dict[tuple[str, Direction], bytes] = {}

    def tap(link: str, direction: Direction, data: bytes) -> None:
        traffic[link, direction] = traffic.get((link, direction), b"") + data

    clock = SimulatedClock()
    cell = assemble_twin(load_profile("mash"), PLAN, seed=1, clock=clock, tap=tap, wires=wires)
    cell.open()
    cell.close()
    cell.dispose()
    return traffic, clock.now_s()


def test_over_pseudo_terminals_every_byte_and_every_moment_is_as_in_memory() -> None:
    in_memory, over_pty = _opened_and_closed("memory"), _opened_and_closed("pty")
    assert {name for name, _ in in_memory[0]} == {"arm", "gripper", "display"}
    assert over_pty == in_memory


def test_a_disposed_cell_leaves_no_ports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    cell = assemble_twin(load_profile("mash"), PLAN, seed=1, clock=SimulatedClock(), wires="pty")
    assert len(list(tmp_path.glob("robocell-ports-*/*"))) == 3
    cell.dispose()
    cell.dispose()
    assert list(tmp_path.iterdir()) == []


def test_a_cable_pulled_from_an_open_cell_may_be_put_back() -> None:
    cell = assemble_twin(load_profile("mash"), PLAN, seed=1, clock=SimulatedClock(), wires="pty")
    cell.open()
    cell.behind.wires["arm"].inject(WireFault.UNPLUGGED)
    with pytest.raises(LinkError, match="arm"):
        cell.arm.arm.read_state()
    cell.behind.wires["arm"].clear()
    assert cell.arm.arm.read_state().is_servo_on
    cell.dispose()


@contextmanager
def _ports(profile: Profile, folder: Path) -> Iterator[Profile]:
    """Serve the devices of a cell on ports and yield a profile that points there."""
    clock = SystemClock()
    changes = {}
    with ExitStack() as stack:
        for device in emulate_cell(profile, PLAN, clock, seed=1):
            end = PtyEnd(PtyPort(folder / device.name, device.line))
            stack.enter_context(
                EmulatorServer(device.name, device.emulator, end, clock, lock=device.lock)
            )
            table = getattr(profile, device.name)
            line = table.serial.model_copy(update={"port": end.place})
            changes[device.name] = table.model_copy(update={"serial": line})
        yield profile.model_copy(update=changes)


def test_a_cell_on_the_ports_of_its_profile_works_in_real_time(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    ports = tmp_path / "ports"
    ports.mkdir()
    with _ports(load_profile("mash"), ports) as profile:
        cell = assemble_hardware(
            profile,
            PLAN,
            clock=SystemClock(),
            state_folder=tmp_path,
            screen=BareScreen(),
            cameras={},
        )
        try:
            arm, gripper = cell.arm.arm, cell.gripper
            cell.arm.open()
            assert arm.read_state().is_servo_on
            cell.set_output(profile.outputs.gripper_power, is_on=True)
            assert "PG070" in gripper.open()
            assert "AQUOS" in cell.display.open()
            gripper.close()
            cell.arm.close()
        finally:
            cell.dispose()
    assert caplog.text.count("this driver was never tried") == 3
    assert not [t for t in threading.enumerate() if t.name.startswith("emulator-")]


def test_a_cell_is_assembled_without_its_ports_and_each_device_tells_itself_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    clock = SimulatedClock()
    cell = assemble_hardware(
        load_profile("mash"),
        PLAN,
        clock=clock,
        state_folder=tmp_path,
        screen=BareScreen(),
        cameras={},
    )
    for device, use in (
        ("arm", cell.arm.arm.read_state),
        ("gripper", cell.gripper.read_state),
        ("display", cell.display.is_on),
    ):
        with pytest.raises(LinkError, match=f"{device}: no port COM"):
            use()
    assert "asked again" not in caplog.text
    assert clock.now_s() == 0.0
    cell.dispose()


@pytest.mark.parametrize("framing", ["text", "hc"])
def test_an_arm_on_the_network_works_and_its_cable_may_be_put_back(
    framing: TcpFraming, tmp_path: Path
) -> None:
    clock, mash = SystemClock(), load_profile("mash")
    device = emulate_model("melfa-rv6sdl", None, PLAN, clock, seed=1, on_network=True)
    end = TcpEnd("127.0.0.1", 0, on_connect=device.on_connect)
    address = TcpProfile(host="127.0.0.1", port=end.port)
    arm_table = mash.arm.model_copy(update={"tcp": address, "tcp_framing": framing})
    with EmulatorServer(device.name, device.emulator, end, clock, lock=device.lock):
        cell = assemble_hardware(
            mash.model_copy(update={"arm": arm_table}),
            PLAN,
            clock=clock,
            state_folder=tmp_path,
            screen=BareScreen(),
            cameras={},
        )
        try:
            arm = cell.arm.arm
            assert "RV-6SDL" in cell.arm.open()
            assert arm.read_state().is_servo_on
            device.emulator.inject(WireFault.UNPLUGGED)
            with pytest.raises(LinkError, match="arm"):
                arm.read_state()
            device.emulator.clear()
            assert arm.read_state().is_servo_on
            cell.arm.close()
        finally:
            cell.dispose()
