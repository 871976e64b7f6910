"""Tool points other than the one that the kinematics is built for."""

from __future__ import annotations

from cell.geometry import Pose, Transform


class ToolFrame:
    """Carries poses between the tool in force and the tool of the kinematics."""

    def __init__(self, fitted_mm: tuple[float, float, float]) -> None:
        self._fitted = from_offset(fitted_mm)
        self.tool = self._fitted
        self._fitted_from_tool: Transform | None = None

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
        if self._fitted_from_tool is None:
            return pose
        return (Transform.from_pose(pose) @ self._fitted_from_tool.inverse()).to_pose()

    def from_fitted(self, pose: Pose) -> Pose:
        """Return where the tool in force is when the kinematics' tool is at `pose`."""
        if self._fitted_from_tool is None:
            return pose
        return (Transform.from_pose(pose) @ self._fitted_from_tool).to_pose()


def from_offset(offset_mm: tuple[float, float, float]) -> Pose:
    """Return a tool that is shifted and not turned."""
    x, y, z = offset_mm
    return Pose(x, y, z, 0.0, 0.0, 0.0)
