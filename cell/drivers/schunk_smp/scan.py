"""Which modules answer on a line."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cell.clock import Clock
from cell.drivers.schunk_smp.commands import GetConfig
from cell.drivers.schunk_smp.conversation import Conversation
from cell.drivers.schunk_smp.replies import Identity
from cell.errors import DeviceTimeout
from cell.links.base import Link


@dataclass(frozen=True, slots=True)
class FoundModule:
    """A module that answered."""

    module_id: int
    kind: str
    firmware: int


def find_modules(
    link: Link,
    clock: Clock,
    *,
    device: str = "gripper",
    ids: Iterable[int] = range(1, 33),
    timeout_s: float = 0.1,
) -> list[FoundModule]:
    """Ask one id after the other who is there; ids are 1 to 255, most are below 33.

    Args:
        link: The line.
        clock: What the time-out is measured with.
        device: Name of the line in messages.
        ids: The ids to ask.
        timeout_s: How long each may take to answer.

    Returns:
        The modules that answered, in the order of `ids`.

    Raises:
        DeviceError: A module refuses to say who it is.
        LinkError: The link is closed or broken.
    """
    found = []
    for module_id in ids:
        conversation = Conversation(link, clock, device=device, module=module_id, attempts=1)
        try:
            answer = conversation.ask(GetConfig(), timeout_s=timeout_s)
        except DeviceTimeout:
            continue
        if isinstance(answer, Identity):
            found.append(FoundModule(module_id, answer.kind, answer.firmware))
    return found
