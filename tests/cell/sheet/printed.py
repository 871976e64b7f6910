"""Reads back what a PDF of the sheet draws, so that tests measure the file itself."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

POINTS_PER_MM = 72.0 / 25.4


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedPage:
    """A page of a PDF.

    Attributes:
        width_mm: Width of the paper.
        height_mm: Height of the paper.
        window_mm: x, y, width, height of what is shown of the sheet, on the page.
        shift_mm: Page x, y of the sheet's corner.
        boxes_mm: Filled rectangles of the sheet: x, y, width, height on the page, and the
            fill's red, green, blue.
        texts: What is written.
    """

    width_mm: float
    height_mm: float
    window_mm: tuple[float, float, float, float]
    shift_mm: tuple[float, float]
    boxes_mm: tuple[tuple[float, ...], ...]
    texts: tuple[str, ...]

    def pixels(self, dots_per_inch: float) -> NDArray[np.uint8]:
        """Return the page's rectangles as a printer would set them, (h, w, 3)."""
        scale = dots_per_inch / 25.4
        size = round(self.height_mm * scale), round(self.width_mm * scale)
        page = np.full((*size, 3), 255, np.uint8)
        left, top, wide, tall = self.window_mm
        for x, y, w, h, *rgb in self.boxes_mm:
            x0, x1 = max(x, left), min(x + w, left + wide)
            y0, y1 = max(y, top), min(y + h, top + tall)
            if x1 > x0 and y1 > y0:
                rows = slice(round(y0 * scale), round(y1 * scale))
                columns = slice(round(x0 * scale), round(x1 * scale))
                page[rows, columns] = [round(255 * c) for c in rgb]
        return page


def pages_in(pdf: bytes) -> tuple[PrintedPage, ...]:
    """Return the pages of a PDF as `cell.sheet.pdf` writes it."""
    check_places(pdf)
    sizes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    streams = re.findall(rb"stream\n(.*?)\nendstream", pdf, flags=re.DOTALL)
    assert len(sizes) == len(streams)
    return tuple(
        _page(float(w) / POINTS_PER_MM, float(h) / POINTS_PER_MM, stream.decode("cp1252"))
        for (w, h), stream in zip(sizes, streams, strict=True)
    )


def check_places(pdf: bytes) -> None:
    """See that the table of objects is where it is said to be and every entry is right."""
    begin = int(pdf.rsplit(b"startxref\n", 1)[1].split(b"\n")[0])
    assert pdf[begin:].startswith(b"xref\n")
    places = re.findall(rb"(\d{10}) 00000 n ", pdf[begin:])
    for number, place in enumerate(places, start=1):
        assert pdf[int(place) :].startswith(f"{number} 0 obj\n".encode())
    for found in re.finditer(rb"/Length (\d+) >>\nstream\n", pdf):
        assert pdf[found.end() + int(found[1]) :].startswith(b"\nendstream")


def _page(width_mm: float, height_mm: float, content: str) -> PrintedPage:
    lines = content.split("\n")
    a, b, c, d, e, f = (float(v) for v in lines[0].split()[:6])
    assert (a, d) == (np.float64(a), -a)
    assert abs(a - POINTS_PER_MM) < 1e-6
    assert (b, c, e) == (0.0, 0.0, 0.0)
    assert abs(f - height_mm * POINTS_PER_MM) < 1e-4
    assert lines[1] == "q"
    window = tuple(float(v) for v in lines[2].split()[:4])
    shift = lines[3].split()
    assert shift[:4] == ["1", "0", "0", "1"]
    dx, dy = float(shift[4]), float(shift[5])
    boxes: list[tuple[float, ...]] = []
    for line in lines[4 : lines.index("Q")]:
        fill = re.match(r"([\d.]+) ([\d.]+) ([\d.]+) rg ", line)
        if fill and re.search(r" re( |$)", line) and line.endswith(" f"):
            rgb = [float(v) for v in fill.groups()]
            for box in re.findall(r"([-\d.]+) ([-\d.]+) ([-\d.]+) ([-\d.]+) re", line):
                x, y, w, h = (float(v) for v in box)
                boxes.append((x + dx, y + dy, w, h, *rgb))
    texts = tuple(re.findall(r"Tm \((.*)\) Tj", content))
    return PrintedPage(
        width_mm=width_mm,
        height_mm=height_mm,
        window_mm=(window[0], window[1], window[2], window[3]),
        shift_mm=(dx, dy),
        boxes_mm=tuple(boxes),
        texts=texts,
    )
