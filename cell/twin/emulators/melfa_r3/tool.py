"""Tool points and bases other than those that the kinematics is built for."""

from __future__ import annotations

from cell.geometry import Pose, Transform


class ToolFrame:
    """Carries poses between the tool and base in force and those of the kinematics."""

    def __init__(self, fitted_mm: tuple[float, float, float]) -> None:
        self._fitted = from_offset(fitted_mm)
        self.tool = self._fitted
        self._fitted_from_tool: Transform | None = None
        self._world_from_base: Transform | None = None

    def set_base(self, base: Pose) -> None:
        """Give poses in another frame from now on: `base` is the robot's base in it."""
        is_itself = base == Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self._world_from_base = None if is_itself else Transform.from_pose(base)

    def select(self, tool: Pose) -> None:
        """Put a tool in force, given in the flange frame."""
        self.tool = tool
        if tool == self._fitted:
            self._fitted_from_tool = None
        else:
            fitted, other = Transform.from_pose(self._fitted), Transform.from_pose(tool)
            self._fitted_from_tool = fitted.inverse() @ other

    def to_fitted(self, pose: Pose) -> Pose:
        """Return where the kinematics' tool is when the tool in force is at `pose`."""
        tool, base = self._fitted_from_tool, self._world_from_base
        if tool is None and base is None:
            return pose
        carried = Transform.from_pose(pose)
        if base is not None:
            carried = base.inverse() @ carried
        return (carried if tool is None else carried @ tool.inverse()).to_pose()

    def from_fitted(self, pose: Pose) -> Pose:
        """Return where the tool in force is when the kinematics' tool is at `pose`."""
        tool, base = self._fitted_from_tool, self._world_from_base
        if tool is None and base is None:
            return pose
        carried = Transform.from_pose(pose)
        if tool is not None:
            carried = carried @ tool
        return (carried if base is None else base @ carried).to_pose()


def from_offset(offset_mm: tuple[float, float, float]) -> Pose:
    """Return a tool that is shifted and not turned."""
    x, y, z = offset_mm
    return Pose(x, y, z, 0.0, 0.0, 0.0)
