"""Tests every component of the cell while no session runs, and reports what fails, once.

The reference's watchdog (Dubec 2011, 5.2): every two hours the arm moves and returns, the
fingers open and close, television and lights go on and off, each camera takes a picture.
"""

from cell.watchdog.calibrations import CalibrationCheck, CalibrationWord, Sight
from cell.watchdog.components import ComponentTest, component_tests
from cell.watchdog.evidence import Evidence, WireLog
from cell.watchdog.history import Fault, History, TestRecord
from cell.watchdog.outbox import Outbox
from cell.watchdog.thread import WatchdogThread
from cell.watchdog.watchdog import Round, Watchdog

__all__ = [
    "CalibrationCheck",
    "CalibrationWord",
    "ComponentTest",
    "Evidence",
    "Fault",
    "History",
    "Outbox",
    "Round",
    "Sight",
    "TestRecord",
    "Watchdog",
    "WatchdogThread",
    "WireLog",
    "component_tests",
]
