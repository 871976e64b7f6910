"""One examination from end to end: what is looked at, in which order, and what depends on what.

One dead device does not keep the others from being examined: whatever goes wrong inside a
check ends that check and is written down.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Literal

from cell.doctor.checks.arm import ArmExamination
from cell.doctor.checks.calibration import check_calibration
from cell.doctor.checks.cameras import check_cameras
from cell.doctor.checks.computer import (
    ClockWatch,
    check_clock,
    check_folders,
    check_kept,
    check_lock,
    check_server_port,
)
from cell.doctor.checks.display import check_display, check_page
from cell.doctor.checks.gripper import check_gripper
from cell.doctor.checks.lights import Lights
from cell.doctor.checks.lines import hear_device, judge_line, judge_link_error, opened_line
from cell.doctor.checks.profile import check_profile
from cell.doctor.checks.store import check_store
from cell.doctor.environment import Environment
from cell.doctor.findings import Report
from cell.doctor.learned import LearnedPicture
from cell.doctor.notes import Notes
from cell.doctor.patient import Patient
from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.errors import CellError, DeviceTimeout, LinkError, ProfileError
from cell.profile import Profile

Component = Literal[
    "computer", "profile", "arm", "gripper", "display", "screen", "cameras", "calibration", "store"
]
COMPONENTS: tuple[Component, ...] = (
    "computer", "profile", "arm", "gripper", "display", "screen", "cameras", "calibration", "store",
)  # fmt: skip

Meet = Callable[[], AbstractContextManager[Patient]]
"""Makes the patient ready, and puts it away afterwards."""

Progress = Callable[[str], None]
"""Told in a few words what is looked at now."""

_NEEDS_ARM = frozenset({"arm", "gripper", "cameras"})


def quiet(what: str) -> None:
    """Tell nobody."""


def examine(
    profile: Profile,
    environment: Environment,
    meet: Meet,
    *,
    only: Component | None = None,
    learned: Mapping[str, LearnedPicture] | None = None,
    progress: Progress = quiet,
) -> Report:
    """Examine a cell: its computer first, then its devices.

    Args:
        profile: The cell's profile.
        environment: The computer around it.
        meet: Makes the cell's parts ready; called once, unless another program has the cell.
        only: Look at one component and at what it depends on; at all unless given.
        learned: Pictures of a healthy cell by camera, to compare with.
        progress: Told what is looked at.
    """
    examination = _Examination(environment, Notes(), only, learned or {}, progress)
    return examination.run(profile, meet)


def report_of_invalid_profile(error: ProfileError) -> Report:
    """Return the report on a profile that cannot be read; nothing else can be examined."""
    notes = Notes()
    notes.find("profile-invalid", "profile", "the profile cannot be used", str(error))
    notes.skip("cell", "everything else", "without a profile nobody knows what there should be")
    return notes.report()


class _Examination:
    """The order of things, and the guard around each check."""

    def __init__(
        self,
        environment: Environment,
        notes: Notes,
        only: Component | None,
        learned: Mapping[str, LearnedPicture],
        progress: Progress,
    ) -> None:
        self._environment = environment
        self._notes = notes
        self._only = only
        self._learned = learned
        self._progress = progress

    def run(self, profile: Profile, meet: Meet) -> Report:
        """Make every check that is wanted and return what it came to."""
        notes, environment = self._notes, self._environment
        watch = ClockWatch(environment)
        self._computer(profile)
        if notes.has("cell-in-use"):
            notes.skip("cell", "all devices", "another program works with them")
            self._page(profile)
            return notes.report()
        try:
            with meet() as patient:
                self._patient(patient)
        except (CellError, OSError) as error:
            notes.skip("cell", "devices", str(error))
        notes.judge_repeats()
        if self._wants("computer"):
            watch.judge(notes)
        return notes.report()

    def _wants(self, component: str) -> bool:
        return self._only in (None, component)

    def _computer(self, profile: Profile) -> None:
        notes, environment = self._notes, self._environment
        # Whatever is examined: with a cell that somebody else has, nothing else makes sense.
        self._guard("computer", "lock", lambda: check_lock(environment, notes))
        if not self._wants("computer"):
            return
        self._progress("computer")
        self._guard("computer", "folders", lambda: check_folders(environment, notes))
        self._guard("computer", "kept files", lambda: check_kept(environment, notes))
        self._guard("computer", "clock", lambda: check_clock(environment, notes))
        if not notes.has("cell-in-use"):
            self._guard(
                "computer", "server port", lambda: check_server_port(profile, environment, notes)
            )

    def _patient(self, patient: Patient) -> None:
        notes, environment = self._notes, self._environment
        if self._wants("profile"):
            self._progress("profile")
            self._guard("profile", "profile", lambda: check_profile(patient, notes))
        if self._only is None or self._only in _NEEDS_ARM:
            self._arm_and_what_hangs_on_it(patient)
        if self._wants("display"):
            self._progress("television")
            self._device(patient, "display", lambda: check_display(patient, environment, notes))
        self._page(patient.profile)
        if self._wants("calibration"):
            self._progress("calibration")
            self._guard(
                "calibration", "plane maps", lambda: check_calibration(patient, environment, notes)
            )
        if self._wants("store"):
            self._progress("store")
            self._guard("store", "ledger", lambda: check_store(patient, notes))

    def _page(self, profile: Profile) -> None:
        """Ask the page on the screen, which may be done while another program has the cell."""
        notes, environment = self._notes, self._environment
        if self._wants("screen"):
            self._guard("screen", "page", lambda: check_page(profile, environment, notes))

    def _arm_and_what_hangs_on_it(self, patient: Patient) -> None:
        """Examine the arm; its controller then switches what gripper and cameras need."""
        if not patient.profile.arm.enabled:
            self._notes.skip("arm", "everything", "the profile disables it")
            self._hanging(patient, None)
            return
        self._progress("arm")
        with opened_line(patient, self._environment, self._notes, "arm") as link:
            arm: ArmExamination | None = None
            if link is not None and judge_line(
                self._environment, self._notes, "arm", hear_device(patient, link, "arm")
            ):
                arm = ArmExamination(patient, link, self._notes)
                if not self._guard("arm", "controller", arm.run):
                    self._guard("arm", "giving back", arm.close)
                    arm = None
            try:
                self._hanging(patient, arm)
            finally:
                if arm is not None:
                    self._guard("arm", "giving back", arm.close)

    def _hanging(self, patient: Patient, arm: ArmExamination | None) -> None:
        notes, environment = self._notes, self._environment
        if self._wants("gripper"):
            self._progress("gripper")
            self._device(
                patient, "gripper", lambda: check_gripper(patient, environment, arm, notes)
            )
        if self._wants("cameras"):
            self._progress("lights and cameras")
            lights = Lights(patient, arm, notes)
            self._guard(
                "cameras",
                "cameras",
                lambda: check_cameras(patient, lights, self._learned, notes, self._guard),
            )
            self._guard("lights", "switching back", lights.restore)

    def _device(self, patient: Patient, device: str, check: Callable[[], None]) -> None:
        is_enabled = {
            "gripper": patient.profile.gripper.enabled,
            "display": patient.profile.display.enabled,
        }
        if not is_enabled[device]:
            self._notes.skip(device, "everything", "the profile disables it")
            return
        self._guard(device, "device", check)

    def _guard(self, component: str, what: str, check: Callable[[], None]) -> bool:
        """Make one check; whatever it fails with is written down. Return whether it ended well."""
        notes = self._notes
        try:
            check()
        except LinkError as error:
            self._judge_break(component, error)
        except (DeviceTimeout, GarbledMessage) as error:
            notes.skip(component, what, str(error))
            if not notes.is_troubled(component):
                problem = f"the {component} answered at first and then failed"
                notes.find("line-unreliable", component, problem, str(error))
        except (CellError, OSError) as error:
            notes.skip(component, what, str(error))
        else:
            return True
        return False

    def _judge_break(self, component: str, error: LinkError) -> None:
        if component not in ("arm", "gripper", "display"):
            self._notes.skip(component, "line", str(error))
        elif not self._notes.has("cable-out", component=component):
            judge_link_error(self._environment, self._notes, component, error)
