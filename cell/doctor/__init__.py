"""The doctor: finds out why a cell does not work, says it with evidence, and what to do.

It moves nothing. What it opens it closes; the operation right it takes only where it is
free, and gives it back; what it must switch on in order to look (the gripper's power, the
lights) it switches back.
"""

from __future__ import annotations

from cell.doctor.causes import CAUSES, cause_of
from cell.doctor.environment import Environment, PageState, PortState, SystemEnvironment
from cell.doctor.examination import COMPONENTS, Component, examine, report_of_invalid_profile
from cell.doctor.findings import PAGE, Cause, Finding, Fine, Report, Unchecked
from cell.doctor.patient import OpenLine, Patient

__all__ = [
    "CAUSES",
    "COMPONENTS",
    "PAGE",
    "Cause",
    "Component",
    "Environment",
    "Fine",
    "Finding",
    "OpenLine",
    "PageState",
    "Patient",
    "PortState",
    "Report",
    "SystemEnvironment",
    "Unchecked",
    "cause_of",
    "examine",
    "report_of_invalid_profile",
]
