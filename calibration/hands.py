"""Does what a procedure asks of a cell: lights, screen, cameras, blocks, arm.

A cell is made and brought up only when something is asked that needs it, so that a procedure
that works on files alone needs none.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from calibration.errors import CalibrationError
from calibration.pictures import picture_of_frame, read_picture_file
from calibration.requests import (
    Answer,
    Capture,
    Light,
    MoveTool,
    Picture,
    PutBlock,
    ReadFeatures,
    ReadPicture,
    ReadTool,
    Request,
    ReturnBlock,
    SetFeature,
    Show,
    StandAside,
    ToolReading,
)
from calibration.standing import Standing
from cell.devices.camera import Camera
from cell.devices.camera_features import CameraFeature
from cell.errors import DeviceError, MotionRefused, UnreachablePose
from cell.robot_cell import RobotCell
from cell.store import TablePlace


class CellHands:
    """The hands of a procedure on a cell with a playground.

    Args:
        make_cell: Returns the cell, closed; called once, when it is needed.
    """

    def __init__(self, make_cell: Callable[[], RobotCell]) -> None:
        self._make_cell = make_cell
        self._cell: RobotCell | None = None
        self._is_begun = False
        self._is_resumed = False
        self._out: set[int] = set()

    @property
    def cell(self) -> RobotCell | None:
        """The cell; None as long as nothing needed it."""
        return self._cell

    def perform(self, request: Request) -> Answer:
        """Do what is asked and return the answer.

        Raises:
            CellError: A device fails, or the guard turns a motion down.
            CalibrationError: The cell has not what is asked for.
        """
        match request:
            case ReadPicture():
                return read_picture_file(Path(request.path))
            case Capture():
                return self._capture(request)
            case ReadFeatures():
                return self._camera(request.camera).features()
            case SetFeature():
                return self._set_feature(request)
            case Light():
                self._up().switch_lights(is_on=request.is_on)
            case Show(pixels=None):
                self._up().show(request.name)
            case Show(pixels=pixels) if pixels is not None:
                self._up().show_pixels(pixels, request.name)
            case PutBlock():
                return self._put(request)
            case ReturnBlock():
                self._return(request.slot)
            case StandAside():
                self._stand_aside()
            case MoveTool():
                return self._move(request)
            case ReadTool():
                return self._tool()
            case _:
                raise CalibrationError(
                    f"a {type(request).__name__} is not for the cell to carry out"
                )
        return None

    def resume(self) -> None:
        """Let blocks that lie out stay where they are: an earlier run put them there."""
        self._is_resumed = True

    def restore(self, standing: Standing) -> None:
        """Bring about again what an interrupted run had brought about.

        Raises:
            CellError: A device fails, or a block is not where the ledger has it.
        """
        wanted = {put.slot: put for put in standing.blocks}
        if wanted or standing.others():
            cell = self._up()
            for slot in set(cell.ledger.blocks_out()) - set(wanted):
                self._return(slot)
            for put in wanted.values():
                self._out.add(put.slot)
                if cell.ledger.blocks_out().get(put.slot) != put.place:
                    self._put(put)
        for request in standing.others():
            self.perform(request)

    def bring_home(self) -> None:
        """Bring every block home that was brought out, and stand aside.

        Raises:
            CellError: A device fails, or a block is not where the ledger has it.
        """
        if self._cell is not None and self._out:
            self._cell.clean_objects(sorted(self._out))
            self._out.clear()
            self._stand_aside()

    def close(self) -> None:
        """Switch everything off and give the cell back."""
        cell, self._cell = self._cell, None
        if cell is not None:
            cell.dispose()

    def _made(self) -> RobotCell:
        if self._cell is None:
            self._cell = self._make_cell()
        return self._cell

    def _up(self) -> RobotCell:
        """Return the cell with its devices up and a table that is as the run needs it."""
        cell = self._made()
        cell.open()
        if not self._is_begun:
            self._is_begun = True
            if self._is_resumed:
                # Closes a transfer that was cut short; what lies out stays there.
                cell.clean_objects(())
            elif not cell.manipulator.is_table_clean():
                cell.clean()
        return cell

    def _camera(self, name: str) -> Camera:
        camera = self._made().cameras.get(name)
        if camera is None:
            known = ", ".join(sorted(self._made().cameras))
            raise DeviceError(f"camera {name}", f"is not in the profile; known are {known}")
        return camera

    def _capture(self, request: Capture) -> Picture:
        return picture_of_frame(self._made().grab(request.camera, is_fresh=True))

    def _set_feature(self, request: SetFeature) -> CameraFeature:
        camera = self._camera(request.camera)
        if request.absolute is not None:
            return camera.set_absolute(request.feature, request.absolute)
        if request.raw is not None:
            return camera.set_raw(request.feature, request.raw)
        raise CalibrationError(f"no value is given for {request.feature} of {request.camera}")

    def _put(self, request: PutBlock) -> TablePlace:
        cell = self._up()
        profile = cell.profile
        if not (profile.gripper.enabled and profile.arm.enabled and profile.manipulation.enabled):
            raise CalibrationError(
                f"the arm of {profile.name} moves no blocks (its profile disables it); put the "
                "block there by hand and choose the procedure's manual way"
            )
        self._out.add(request.slot)
        cell.carry(request.slot, request.place)
        return request.place

    def _return(self, slot: int) -> None:
        self._up().clean_objects((slot,))
        self._out.discard(slot)

    def _stand_aside(self) -> None:
        cell = self._up()
        cell.arm.raise_to(cell.profile.heights.service_mm)
        cell.arm.rest()

    def _move(self, request: MoveTool) -> ToolReading:
        arm, pose = self._up().arm, request.pose
        if request.by_joints:
            arm.move_joint(pose)
            return self._tool()
        try:
            arm.move_linear(pose)
        except (MotionRefused, UnreachablePose) as line:
            try:
                arm.move_joint(pose)
            except (MotionRefused, UnreachablePose):
                raise line from None
        return self._tool()

    def _tool(self) -> ToolReading:
        cell = self._up()
        return ToolReading(pose=cell.read_pose(), joints=cell.arm.joints())


class FileHands:
    """The hands of a procedure where there is no playground: they read files.

    Args:
        cell: Name of the cell, for messages.
    """

    def __init__(self, cell: str) -> None:
        self._cell = cell

    def perform(self, request: Request) -> Answer:
        """Read a picture from a file.

        Raises:
            CalibrationError: Anything else is asked, or the file is no picture.
        """
        if isinstance(request, ReadPicture):
            return read_picture_file(Path(request.path))
        raise CalibrationError(
            f"the cell {self._cell} has no playground with cameras that a procedure could use; "
            "give it pictures from files, or figures"
        )
