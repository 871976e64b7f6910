"""A cell of which the profile disables something does what is left, and says so."""

from __future__ import annotations

import pytest

from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.events import DeviceSkipped, EventBus, MotionFinished
from cell.manipulation import Deployment
from cell.profile import Profile
from cell.twin_cell import TwinCell
from sessions.hosting import store_plan
from tests.sessions.fault_rig import PROFILE, SCRIPT, starts_motion

PLACE = Deployment(slot=7, x_mm=650.0, y_mm=-105.0)


class Played:
    """A cell without some device that was opened, used and closed."""

    def __init__(self, table: str) -> None:
        changed = getattr(PROFILE, table).model_copy(update={"enabled": False})
        profile: Profile = PROFILE.model_copy(update={table: changed})
        clock = SimulatedClock()
        events = EventBus(clock)
        self.sent: list[tuple[str, bytes]] = []
        subscription, _ = events.subscribe()
        self.cell: TwinCell = assemble_twin(
            profile,
            store_plan(SCRIPT),
            seed=1,
            clock=clock,
            events=events,
            tap=lambda link, way, data: self.sent.append((link, data)),
        )
        self.cell.open()
        self.cell.show("forest")
        self.cell.lay_out([PLACE])
        self.cell.move_to(670.0, -165.0, 150.0)
        self.pose = self.cell.read_pose()
        self.out = dict(self.cell.ledger.blocks_out())
        self.home = self.cell.clean()
        self.cell.close()
        self.bodies = [event.body for event in subscription.take()]
        self.cell.dispose()

    def skipped(self, device: str) -> list[str]:
        return [b.what for b in self.bodies if isinstance(b, DeviceSkipped) and b.device == device]

    def motions(self, link: str) -> int:
        return sum(name == link and starts_motion(name, data) for name, data in self.sent)


def test_without_the_arm_steps_are_answered_and_nothing_moves() -> None:
    played = Played("arm")
    assert (played.pose.x_mm, played.pose.y_mm) == pytest.approx((670.0, -165.0))
    assert played.sent == [] or {link for link, _ in played.sent} == {"display"}
    assert len(played.skipped("arm")) == 1
    assert not any(isinstance(body, MotionFinished) for body in played.bodies)


def test_without_the_television_the_playground_keeps_its_look() -> None:
    played = Played("display")
    assert played.skipped("display") == ["the playground keeps its look"]
    assert all(link != "display" for link, _ in played.sent)
    assert played.home == [7]


@pytest.mark.parametrize("table", ["gripper", "manipulation"])
def test_without_gripper_or_manipulation_people_are_told_which_block_goes_where(
    table: str,
) -> None:
    played = Played(table)
    asked = [what for what in played.skipped("manipulation") if what.startswith("bring")]
    assert asked[0].startswith("bring the red cube of slot 7 to (650, -105) mm")
    assert asked[1].startswith("bring the red cube of slot 7 back into its slot")
    assert list(played.out) == [7]
    assert played.home == [7]
    assert played.motions("arm") > 0
    if table == "gripper":
        assert all(link != "gripper" for link, _ in played.sent)
