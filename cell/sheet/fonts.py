"""How wide text is in Helvetica, for anchors in formats that know none.

Widths in thousandths of the size are those of Adobe's font metrics for the base fonts
(Helvetica.afm and Helvetica-Bold.afm, characters 32 to 126).
"""

from __future__ import annotations

from typing import Final

_PLAIN: Final = (
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
    1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
    333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
    556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
)  # fmt: skip
_BOLD: Final = (
    278, 333, 474, 556, 556, 889, 722, 238, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 333, 333, 584, 584, 584, 611,
    975, 722, 722, 722, 722, 667, 611, 778, 722, 278, 556, 722, 611, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 333, 278, 333, 584, 556,
    333, 556, 611, 556, 611, 556, 333, 611, 611, 278, 278, 556, 278, 889, 611, 611,
    611, 611, 389, 556, 333, 611, 556, 778, 556, 556, 500, 389, 280, 389, 584,
)  # fmt: skip
_OTHER: Final = 556
CAPITAL_SHARE: Final = 0.718
"""Height of a capital as a share of the size."""


def text_width_mm(text: str, size_mm: float, *, bold: bool = False) -> float:
    """Return the width of a line of text."""
    table = _BOLD if bold else _PLAIN
    units = sum(table[ord(c) - 32] if 32 <= ord(c) <= 126 else _OTHER for c in text)
    return units * size_mm / 1000.0
