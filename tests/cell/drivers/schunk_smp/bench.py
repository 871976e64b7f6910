"""A gripper's driver on an emulated module, with hands on the wire between them."""

from cell.clock import SimulatedClock
from cell.drivers.schunk_smp.driver import SchunkGripper
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.links.base import Link
from cell.links.memory import MemoryLink
from cell.stop import StopToken
from cell.twin.emulators.schunk_smp import SchunkModule, SchunkModuleSettings
from tests.cell.twin.emulators.schunk_smp.bodies import BareFingers


class MeddledLink:
    """A link on which bytes can be slipped in or get lost, and which counts what is sent."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self.slipped = b""
        self.after_next_request = b""
        self.lost = b""
        self.sent: list[bytes] = []

    @property
    def name(self) -> str:
        return self._link.name

    def write(self, data: bytes) -> None:
        self.sent.append(data)
        self._link.write(data)
        self.slipped += self.after_next_request
        self.after_next_request = b""

    def read(self, timeout_s: float) -> bytes:
        if self.slipped:
            data, self.slipped = self.slipped, b""
            return data
        data = self._link.read(timeout_s)
        return data.replace(self.lost, b"") if self.lost else data

    def close(self) -> None:
        self._link.close()


class GripperBench:
    """Body, module, wire and driver on one clock."""

    def __init__(
        self,
        *,
        is_referenced: bool = True,
        module: SchunkModuleSettings | None = None,
        settings: SchunkSettings | None = None,
    ) -> None:
        self.clock = SimulatedClock(50.0)
        self.body = BareFingers()
        self.module = SchunkModule(
            self.body, module or SchunkModuleSettings(), is_referenced=is_referenced
        )
        self.wire = MeddledLink(MemoryLink("gripper", self.module, self.clock))
        self.token = StopToken()
        self.warnings: list[str] = []
        self.gripper = SchunkGripper(
            self.wire,
            self.clock,
            settings or SchunkSettings(),
            token=self.token,
            on_warning=self.warnings.append,
        )

    def opened(self) -> "GripperBench":
        self.gripper.open()
        self.wire.sent.clear()
        return self

    def commands(self) -> list[int]:
        """Return the command bytes that were sent, oldest first."""
        return [data[3] for data in self.wire.sent]
