"""Every arm that is under the arm contract; a new one gets a line here."""

from __future__ import annotations

from typing import Any

from tests.contracts.arm.case import ArmCase
from tests.contracts.arm.ibm7545 import IBM7545
from tests.contracts.arm.lynx import LYNX
from tests.contracts.arm.melfa import MELFA, MELFA_HC, MELFA_TEXT

# The rigs differ in type, and only the hands of a case ever see its own.
ARMS: dict[str, ArmCase[Any]] = {
    "melfa": MELFA,
    "melfa over tcp": MELFA_TEXT,
    "melfa over tcp in frames": MELFA_HC,
    "ibm7545": IBM7545,
    "lynx": LYNX,
}
