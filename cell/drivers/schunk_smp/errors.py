"""What can be wrong with bytes of the SCHUNK Motion Protocol."""

from __future__ import annotations

from cell.errors import CellError


class MalformedMessage(CellError):
    """A frame with a right checksum does not hold what its command byte promises.

    Attributes:
        code: The protocol's own number for the fault, such as `Code.MESSAGE_LENGTH`.
    """

    def __init__(self, problem: str, *, code: int) -> None:
        self.code = code
        super().__init__(problem)
