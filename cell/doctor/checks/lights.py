"""The lights: what their output reads, and how the cell is arranged for its cameras."""

from __future__ import annotations

from cell.doctor.checks.arm import ArmExamination
from cell.doctor.notes import Notes
from cell.doctor.patient import Patient


class Lights:
    """Switches the lights on for the cameras, and back as they were.

    Args:
        patient: The cell.
        arm: The conversation with the controller that switches them; None where it cannot
            be asked.
        notes: Where to write.
    """

    def __init__(self, patient: Patient, arm: ArmExamination | None, notes: Notes) -> None:
        self._patient = patient
        self._arm = arm
        self._notes = notes
        self._bit = patient.profile.outputs.lights
        self._is_to_be_restored = False

    def switch_on(self) -> str:
        """Have the lights on; return why they are not, empty if they are.

        Raises:
            DeviceError: The controller does not answer as it should.
        """
        arm, notes, bit = self._arm, self._notes, self._bit
        if arm is None:
            return "the arm controller, which switches the lights, cannot be asked"
        if arm.reads_on(bit):
            notes.fine("lights", f"output {bit} reads on")
            return ""
        if self._patient.is_in_service:
            problem = "the lights are off in the middle of work"
            notes.find("lights-off", "lights", problem, f"output {bit} reads off")
            return "the lights are off"
        if not arm.take_right():
            return "the arm controller does not give the right to switch the lights on"
        self._is_to_be_restored = True
        if not arm.switch_output(bit, is_on=True):
            problem = "the output of the lights does not come on"
            notes.find("lamp-dead", "lights", problem, f"output {bit} switched on, reads off")
            return "the lights do not come on"
        notes.fine("lights", f"output {bit} comes on")
        return ""

    def is_arm_aside(self) -> bool:
        """Return whether the arm is known to stand aside, as it does between sessions."""
        arm = self._arm
        return arm is not None and arm.stands_at(self._patient.profile.arm.rest_deg)

    def restore(self) -> None:
        """Switch the lights off again, if it was the doctor who switched them on.

        Raises:
            DeviceError: The controller does not answer as it should.
        """
        if self._is_to_be_restored and self._arm is not None:
            self._is_to_be_restored = False
            self._arm.switch_output(self._bit, is_on=False)
