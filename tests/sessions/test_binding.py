from __future__ import annotations

import dataclasses

import pytest

from cell.manipulation import Deployment
from cell.profile import LatticeProfile
from dsl.host import Placement
from sessions.binding import CellHost, camera_of, check_servable
from sessions.errors import ScriptUnservable
from sessions.script import TaskSpec, ViewSpec
from tests.sessions.fakes import PROFILE, FakeCell, FakeScript


class DeployedCell(FakeCell):
    """Keeps what it was asked to lay out."""

    deployments: tuple[Deployment, ...] = ()

    def lay_out(self, deployments: object) -> None:
        assert isinstance(deployments, list)
        self.deployments = tuple(deployments)


@pytest.mark.parametrize(
    ("x", "y", "place_mm"),
    [
        (0, 0, (710.0, -265.0, 136.5)),
        (3, 0, (710.0, -205.0, 136.5)),
        (0, 3, (650.0, -265.0, 136.5)),
        (11, 11, (490.0, -45.0, 136.5)),
    ],
)
def test_a_lattice_point_is_reached_in_millimetres_above_the_block_tops(
    x: int, y: int, place_mm: tuple[float, float, float]
) -> None:
    cell = FakeCell()
    host = CellHost(cell, PROFILE)

    host.move_to(x, y, travel_mm=65.0)

    assert cell.place_mm == place_mm
    assert (host.x, host.y) == (x, y)


def test_blocks_go_to_their_lattice_points() -> None:
    cell = DeployedCell()
    host = CellHost(cell, PROFILE)

    host.lay_out(
        [
            Placement(slot=7, kind="cube", colour="red", x=11, y=11),
            Placement(slot=16, kind="cylinder", colour="green", x=0, y=11, yaw_deg=90.0),
        ]
    )

    assert cell.deployments == (
        Deployment(slot=7, x_mm=490.0, y_mm=-45.0, yaw_deg=0.0),
        Deployment(slot=16, x_mm=490.0, y_mm=-265.0, yaw_deg=90.0),
    )
    assert host.blocks_out == 2


@pytest.mark.parametrize(("angle_deg", "yaw_deg"), [(90.0, 0.0), (0.0, -90.0), (270.0, -180.0)])
def test_a_blocks_width_follows_lattice_x(angle_deg: float, yaw_deg: float) -> None:
    cell = DeployedCell()
    profile = PROFILE.model_copy(update={"lattice": LatticeProfile(angle_deg=angle_deg)})

    CellHost(cell, profile).lay_out([Placement(slot=1, kind="cube", colour="red", x=0, y=0)])

    assert cell.deployments[0].yaw_deg == yaw_deg


def test_the_picture_is_shown() -> None:
    cell = FakeCell()

    CellHost(cell, PROFILE).show("forest")

    assert cell.calls == ["show forest"]


@pytest.mark.parametrize(
    ("view", "camera"), [("CAMERA_TOP", "top"), ("CAMERA_OBLIQUE", "oblique"), ("SIDE", "side")]
)
def test_a_view_names_its_camera(view: str, camera: str) -> None:
    assert camera_of(view) == camera


def test_a_script_whose_views_have_cameras_is_servable() -> None:
    check_servable(FakeScript(), PROFILE)


def test_a_view_without_a_camera_is_told_before_anything_is_served() -> None:
    class Blind(FakeScript):
        def task(self, goal: str, environment: str) -> TaskSpec:
            moon = ViewSpec(name="CAMERA_MOON", mime="image/mif", width_px=640, height_px=480)
            return dataclasses.replace(super().task(goal, environment), views=(moon,))

    with pytest.raises(ScriptUnservable, match=r"LINE has the view CAMERA_MOON.*oblique, top"):
        check_servable(Blind(), PROFILE)
