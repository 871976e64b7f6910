"""An arm that is reached in frames: what the doctor says when no frame comes back."""

from __future__ import annotations

from cell.clock import SimulatedClock
from cell.doctor.checks.listening import greetings, listen
from cell.drivers.melfa_r3.ethernet import FramedLink
from cell.links.memory import MemoryLink
from cell.profile import load_profile
from cell.twin.emulators.melfa_r3.ethernet import EthernetPort
from cell.twin.wire_faults import FaultyEmulator, WireFault
from tests.contracts.arm.rig import ArmRig


def test_a_silent_controller_is_silent_in_frames_too() -> None:
    rig, clock = ArmRig(), SimulatedClock()
    wire = FaultyEmulator(EthernetPort(rig.controller))
    link = FramedLink(MemoryLink("arm", wire, clock), clock)
    known = greetings(load_profile("mash"))
    assert listen(link, clock, "arm", known).verdict == "answers"
    fresh = FramedLink(MemoryLink("arm", wire, clock), clock)
    wire.inject(WireFault.SILENT)
    heard = listen(fresh, clock, "arm", known)
    assert heard.verdict == "silent"
    assert "did not change to frames" in heard.facts[0]
