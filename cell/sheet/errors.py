"""What can go wrong with the store's printed plan."""

from __future__ import annotations

from cell.errors import CellError


class SheetError(CellError):
    """The sheet cannot be drawn, printed or read; the text says what to do."""
