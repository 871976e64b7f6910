"""What can be wrong with a profile."""

from __future__ import annotations

from cell.doctor.findings import Cause

_GROUP = "Profile"
_UNDO = "put the old value back into the profile"

PROFILE: tuple[Cause, ...] = (
    Cause(
        id="profile-invalid",
        title="The profile cannot be used",
        group=_GROUP,
        rank=1,
        see="Every command of the cell ends at once with a sentence about the profile.",
        why="The TOML file has a syntax error, an unknown key, or a value that is not allowed.",
        fix="correct the fields that the finding names; `cell profile check` shows them too",
        found="The file is read and validated; every wrong field is named.",
    ),
    Cause(
        id="profile-same-port",
        title="Two devices have the same port",
        group=_GROUP,
        rank=12,
        see="One device works; the other finds its port taken or gets strange answers.",
        why="A section of the profile was copied and its port not changed.",
        fix="give each device its own port in the profile",
        found="The ports and adapter numbers of all serial tables are compared.",
        undo=_UNDO,
    ),
    Cause(
        id="profile-same-guid",
        title="Two cameras have the same GUID",
        group=_GROUP,
        rank=12,
        see="Two views show the same picture.",
        why="A camera's section was copied and its GUID not changed.",
        fix="enter the GUID that is printed on each camera",
        found="The GUIDs of all cameras are compared.",
        undo=_UNDO,
    ),
    Cause(
        id="profile-laying-height",
        title="The laying height does not fit the surface",
        group=_GROUP,
        rank=13,
        see="The fingers touch the glass, or close above the blocks.",
        why="The heights of the glass and of laying were changed one without the other.",
        fix="set heights.laying_mm so that the fingertips hold a block between the surface "
        "and its top",
        found="The fingertips' height when laying (laying height less the reach of the tips) is "
        "held against the surface and the lowest block.",
        undo=_UNDO,
    ),
    Cause(
        id="profile-slot-unreachable",
        title="A place of the store is out of reach",
        group=_GROUP,
        rank=14,
        see="Laying out or cleaning is refused for some blocks.",
        why="The store's corner or angle is wrong, or the sheet was moved.",
        fix="correct store.corner_mm and store.angle_deg, or move the sheet",
        found="The arm's inverse kinematics is asked for every slot at laying and service height.",
        undo=_UNDO,
    ),
    Cause(
        id="profile-corner-unreachable",
        title="A corner of the lattice is out of reach",
        group=_GROUP,
        rank=14,
        see="Tasks are refused when the server starts, or moves near the border.",
        why="The lattice's origin, step or angle is wrong for this arm and this world.",
        fix="correct lattice.origin_mm, lattice.step_mm or lattice.angle_deg",
        found="The arm's inverse kinematics is asked for the four corners at both heights.",
        undo=_UNDO,
    ),
    Cause(
        id="profile-rest-refused",
        title="The place where the arm stands aside is not allowed",
        group=_GROUP,
        rank=14,
        see="The arm does not stand aside; cleaning ends with a refusal.",
        why="The rest angles violate a joint limit, or put the arm below its lowest height.",
        fix="choose arm.rest_deg within the joint limits and above the lowest flange height",
        found="The rest angles are held against the joint limits and the flange's lowest height.",
        undo=_UNDO,
    ),
    Cause(
        id="profile-camera-missing",
        title="A view has no camera",
        group=_GROUP,
        rank=14,
        see="The server refuses the script.",
        why="A script asks for a view whose camera the profile does not have.",
        fix="add the camera to the profile, or take the view out of the script",
        found="The cameras of the views are looked up in the profile.",
        undo=_UNDO,
    ),
)
