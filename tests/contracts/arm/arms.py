"""Every arm that is under the arm contract; a new one gets a line here."""

from __future__ import annotations

from typing import Any

from tests.contracts.arm.case import ArmCase
from tests.contracts.arm.ibm7545 import IBM7545
from tests.contracts.arm.lynx import LYNX
from tests.contracts.arm.melfa import MELFA

# The rigs differ in type, and only the hands of a case ever see its own.
ARMS: dict[str, ArmCase[Any]] = {
    "melfa": MELFA,
    "ibm7545": IBM7545,
    "lynx": LYNX,
}
