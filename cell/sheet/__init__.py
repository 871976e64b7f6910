"""The store's printed plan: drawn to scale, printed, found again by a camera."""

from cell.sheet.drawing import Drawing
from cell.sheet.errors import SheetError
from cell.sheet.fiducials import Fiducial
from cell.sheet.layout import SheetLayout, lay_out
from cell.sheet.paper import Paper, pages_of, paper_of
from cell.sheet.pdf import Page, pdf_bytes
from cell.sheet.raster import raster
from cell.sheet.store_sheet import draw_sheet
from cell.sheet.svg import svg_text

__all__ = [
    "Drawing",
    "Fiducial",
    "Page",
    "Paper",
    "SheetError",
    "SheetLayout",
    "draw_sheet",
    "lay_out",
    "pages_of",
    "paper_of",
    "pdf_bytes",
    "raster",
    "svg_text",
]
