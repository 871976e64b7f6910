"""SVG, PDF and tiles: every figure where it belongs, to a hundredth of a millimetre."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

from cell.sheet import SheetError, draw_sheet, lay_out, pages_of, paper_of, pdf_bytes, svg_text
from cell.sheet.finding import find_markers
from cell.sheet.fonts import text_width_mm
from cell.sheet.paper import MARGIN_MM, OVERLAP_MM
from tests.cell.sheet.bench import MASH_SLOTS, PROFILE
from tests.cell.sheet.printed import pages_in

LAYOUT = lay_out(MASH_SLOTS, PROFILE.blocks)
DRAWING = draw_sheet(LAYOUT, name="mash (1)")
SVG = "{http://www.w3.org/2000/svg}"
PAPERS = (None, "a4", "a3", "610x420", "A4", "300x2000")


def outlines() -> list[tuple[float, float, float, float]]:
    """Return x, y, width, height of the slots that are boxes."""
    areas = [one.outline for one in LAYOUT.slots if one.size.shape == "box"]
    return [(a.x_mm, a.y_mm, a.width_mm, a.height_mm) for a in areas]


def test_the_svg_is_in_millimetres_and_has_every_slot_in_its_place() -> None:
    root = ElementTree.fromstring(svg_text(DRAWING))  # noqa: S314
    assert root.get("width") == "547mm"
    assert root.get("viewBox") == "0 0 547 368"
    boxes = {
        tuple(float(r.get(k, "nan")) for k in ("x", "y", "width", "height"))
        for r in root.iter(f"{SVG}rect")
    }
    for box in outlines():
        assert any(np.allclose(box, other, atol=0.01) for other in boxes), box
    circles = {(float(c.get("cx", "")), float(c.get("cy", ""))) for c in root.iter(f"{SVG}circle")}
    assert circles == {(x, 350.0) for x in (55.0, 165.0, 275.0, 385.0, 495.0)}
    words = [text.text for text in root.iter(f"{SVG}text")]
    assert "Store plan mash (1)" in words
    assert "13 bridge red" in words


def test_the_ruler_of_the_svg_is_100_mm_long_both_ways() -> None:
    root = ElementTree.fromstring(svg_text(DRAWING))  # noqa: S314
    lengths = []
    for line in root.iter(f"{SVG}line"):
        x1, y1, x2, y2 = (float(line.get(k, "nan")) for k in ("x1", "y1", "x2", "y2"))
        lengths.append((round(abs(x2 - x1), 2), round(abs(y2 - y1), 2)))
    assert lengths.count((100.0, 0.0)) == 1
    assert lengths.count((0.0, 100.0)) == 1


@pytest.mark.parametrize("name", PAPERS)
def test_a_pdf_has_every_slot_and_marker_in_its_place(name: str | None) -> None:
    paper = None if name is None else paper_of(name)
    pages = pages_in(pdf_bytes(pages_of(DRAWING, paper), "plan"))
    for page in pages:
        dx, dy = page.shift_mm
        boxes = np.array([box[:4] for box in page.boxes_mm]) - (dx, dy, 0, 0)
        for box in outlines():
            assert (np.abs(boxes - box) < 0.01).all(axis=1).any(), box
        for one in LAYOUT.fiducials:
            left, top = one.corners_mm[0]
            frame = (left, top, one.size_mm, one.size_mm / 6)
            assert (np.abs(boxes - frame) < 0.01).all(axis=1).any(), one.index
    assert any("Store plan mash \\(1\\)" in page.texts for page in pages)


@pytest.mark.parametrize("name", PAPERS)
def test_the_pages_together_show_the_whole_sheet_and_neighbours_overlap(name: str | None) -> None:
    paper = None if name is None else paper_of(name)
    pages = pages_in(pdf_bytes(pages_of(DRAWING, paper), "plan"))
    seen = np.zeros((LAYOUT.height_mm * 2, LAYOUT.width_mm * 2), np.int32)
    for page in pages:
        x, y, wide, tall = page.window_mm
        assert x >= MARGIN_MM - 1e-6
        assert x + wide <= page.width_mm - MARGIN_MM + 1e-3
        assert y + tall <= page.height_mm - MARGIN_MM + 1e-3
        left, top = x - page.shift_mm[0], y - page.shift_mm[1]
        rows = slice(round(2 * top), round(2 * (top + tall)))
        seen[rows, round(2 * left) : round(2 * (left + wide))] += 1
    assert seen.min() >= 1
    if len(pages) > 1:
        twice = (seen[0] >= 2).sum() if (seen[0] >= 2).any() else (seen[:, 0] >= 2).sum()
        assert twice >= 2 * OVERLAP_MM - 1


def test_a4_takes_six_pages_and_a3_three() -> None:
    assert len(pages_of(DRAWING, paper_of("a4"))) == 6
    assert len(pages_of(DRAWING, paper_of("a3"))) == 3


def test_every_page_tells_where_it_belongs_and_has_rulers() -> None:
    for page in pages_in(pdf_bytes(pages_of(DRAWING, paper_of("a4")), "plan")):
        assert any(text.startswith("page ") and "of 6: row" in text for text in page.texts)
        assert any("must measure 100.0 mm" in text for text in page.texts)


def test_the_markers_of_a_printed_page_are_found_at_150_dots_an_inch() -> None:
    (page,) = pages_in(pdf_bytes(pages_of(DRAWING), "plan"))
    found = {one.marker_id: one for one in find_markers(page.pixels(150.0))}
    assert set(found) == {one.marker_id for one in LAYOUT.fiducials}
    for one in LAYOUT.fiducials:
        printed = (np.array(one.corners_mm) + page.shift_mm) * 150.0 / 25.4 - 0.5
        assert np.abs(found[one.marker_id].corners_px - printed).max() < 1.0


def test_the_same_plan_gives_the_same_bytes_and_another_name_others() -> None:
    again = draw_sheet(lay_out(MASH_SLOTS, PROFILE.blocks), name="mash (1)")
    pages, others = pages_of(DRAWING), pages_of(draw_sheet(LAYOUT, name="other"))
    assert svg_text(again) == svg_text(DRAWING)
    assert pdf_bytes(pages_of(again), "plan") == pdf_bytes(pages, "plan")
    assert pdf_bytes(others, "plan") != pdf_bytes(pages, "plan")


def test_a_name_with_any_letters_is_written() -> None:
    drawing = draw_sheet(LAYOUT, name="Küche ✓ <&> \\")
    assert "K\\374che" not in svg_text(drawing)
    (page,) = pages_in(pdf_bytes(pages_of(drawing), "Küche ("))
    assert any("Küche ? <&>" in text for text in page.texts)
    ElementTree.fromstring(svg_text(drawing))  # noqa: S314


@pytest.mark.parametrize("text", ["a5", "21x29", "0x0", "nonsense", "", "297x", "-210x297"])
def test_paper_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(SheetError):
        paper_of(text)


def test_a_sheet_for_too_many_pages_is_refused() -> None:
    huge = lay_out((replace(MASH_SLOTS[0], x_mm=1900.0, y_mm=1900.0),), PROFILE.blocks)
    with pytest.raises(SheetError, match="pages"):
        pages_of(draw_sheet(huge), paper_of("140x140"))


def test_widths_of_text_are_those_of_the_fonts() -> None:
    assert text_width_mm("Wi", 10.0) == pytest.approx(11.66)
    assert text_width_mm("Wi", 10.0, bold=True) == pytest.approx(12.22)
