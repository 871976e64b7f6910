"""The cameras: who they are, how they are set, and what their pictures tell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from cell.devices.camera import Camera, CameraSettings
from cell.devices.camera_configure import wanted
from cell.devices.camera_features import CameraFeature, CameraIdentity, is_taken, quantity
from cell.doctor.checks.lights import Lights
from cell.doctor.checks.pictures import Look, Viewpoint, judge_pictures, look_through
from cell.doctor.learned import LEARNING_MODE, LearnedPicture
from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.errors import DeviceError

Guard = Callable[[str, str, Callable[[], None]], bool]
"""Makes a check; whatever it fails with is written down."""

_ABSOLUTE_RANGE = (0.0, 1.0)


def check_cameras(
    patient: Patient,
    lights: Lights,
    learned: Mapping[str, LearnedPicture],
    notes: Notes,
    guard: Guard,
) -> None:
    """Examine every camera; the pictures are judged together, lights on.

    Args:
        patient: The cell.
        lights: Switches the lights on for the pictures.
        learned: Pictures of the healthy cell.
        notes: Where to write.
        guard: Around what may fail for one camera.
    """
    if not patient.cameras:
        notes.skip("cameras", "everything", "the profile has none")
        return
    dark_because = "the arm controller failed while it switched the lights"
    verdict: list[str] = []
    if guard("lights", "lights", lambda: verdict.append(lights.switch_on())):
        dark_because = verdict[0]
    looks: list[Look] = []
    for name, camera in patient.cameras.items():
        guard(f"camera {name}", "camera", partial(_examine, patient, name, camera, notes, looks))
    viewpoint = Viewpoint(
        cameras=frozenset(patient.cameras),
        riding=frozenset(patient.riding_cameras),
        is_arm_aside=lights.is_arm_aside(),
        dark_because=dark_because,
    )
    judge_pictures(looks, viewpoint, learned, notes)


def _examine(patient: Patient, name: str, camera: Camera, notes: Notes, looks: list[Look]) -> None:
    """Examine one camera; what it sees is added to the looks."""
    component = f"camera {name}"
    try:
        identity = _identity(camera)
    except DeviceError as error:
        notes.find("camera-missing", component, f"camera {name} is not there", str(error))
        camera.close()
        return
    if not _is_right_one(patient, name, identity.guid, str(identity), notes):
        camera.close()
        return
    try:
        camera.open(LEARNING_MODE)
        _check_features(component, camera, patient.profile.cameras[name].settings, notes)
        looks.append(look_through(name, identity.guid, camera))
    except DeviceError as error:
        torn = "half a picture" in error.problem
        cause = "camera-torn" if torn else "camera-missing"
        words = "gives torn pictures" if torn else "gives no picture"
        notes.find(cause, component, f"camera {name} {words}", str(error))
    finally:
        camera.close()


def _identity(camera: Camera) -> CameraIdentity:
    """Return who a camera is; one that only says so when it is open is opened.

    Raises:
        DeviceError: It cannot be opened; the text says why.
    """
    try:
        return camera.identity
    except DeviceError:
        camera.open(LEARNING_MODE)
        return camera.identity


def _is_right_one(patient: Patient, name: str, guid: str, who: str, notes: Notes) -> bool:
    component = f"camera {name}"
    wanted_guid = patient.profile.cameras[name].guid
    if guid == wanted_guid:
        notes.fine(component, f"identity: {who}")
        return True
    fact = f"GUID {guid} answers, the profile has {wanted_guid}"
    owner = next((n for n, c in patient.profile.cameras.items() if c.guid == guid), "")
    if owner:
        problem = f"the camera in the place of {name} is that of {owner}"
        notes.find("camera-swapped", component, problem, fact)
    else:
        problem = f"another camera is in the place of {name}"
        notes.find("camera-unknown", component, problem, fact)
    return False


def _check_features(component: str, camera: Camera, settings: CameraSettings, notes: Notes) -> None:
    features = {feature.name: feature for feature in camera.features()}
    # The frame rate is the mode's affair, and no setting of the profile.
    ours = {one.name for one in wanted(settings)}
    automatic = sorted(n for n in ours & set(features) if features[n].control == "auto")
    if automatic:
        problem = f"the camera sets {', '.join(automatic)} by itself"
        notes.find("camera-automatic", component, problem, *(f"{n} is auto" for n in automatic))
    else:
        notes.fine(component, "no automatic mode is on")
    different: list[str] = []
    for one in wanted(settings):
        feature = features.get(one.name)
        # What the camera sets by itself differs for that reason.
        if feature is None or feature.name in automatic or feature.control == "off":
            continue
        has = _difference(feature, one.value, is_raw=one.is_raw)
        if has:
            different.append(f"{one.name}: profile {one.value:g}, camera {has}")
    if different:
        problem = "the camera's settings are not those of the profile"
        notes.find("camera-settings-differ", component, problem, *different)
    else:
        notes.fine(component, "its settings are those of the profile")


def _difference(feature: CameraFeature, value: float, *, is_raw: bool) -> str:
    """Return what a camera has instead of a value, empty if it has it."""
    if is_raw:
        return "" if feature.raw in (None, int(value)) else str(feature.raw)
    span = feature.absolute_range or _ABSOLUTE_RANGE
    if feature.absolute is None or is_taken(value, feature.absolute, span):
        return ""
    return quantity(feature.absolute, feature.unit)
