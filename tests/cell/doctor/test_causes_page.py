"""The page of causes is the causes' own, and every link of a finding holds."""

from __future__ import annotations

from pathlib import Path

from cell.doctor import CAUSES, PAGE
from cell.doctor.page import page_of_causes

ROOT = Path(__file__).parents[3]


def test_the_page_is_the_one_that_the_causes_make() -> None:
    assert (ROOT / PAGE).read_text("utf-8") == page_of_causes(), (
        "write it anew: python -c 'from cell.doctor.page import page_of_causes; "
        f'open("{PAGE}", "w").write(page_of_causes())\''
    )


def test_every_link_leads_to_a_heading() -> None:
    headings = {
        line.removeprefix("### ")
        for line in (ROOT / PAGE).read_text("utf-8").splitlines()
        if line.startswith("### ")
    }
    for cause in CAUSES:
        page, _, anchor = cause.link.partition("#")
        assert page == PAGE
        assert anchor in headings


def test_there_are_at_least_45_causes_and_each_says_everything() -> None:
    assert len({cause.id for cause in CAUSES}) == len(CAUSES) >= 45
    for cause in CAUSES:
        assert cause.id == cause.id.lower()
        for text in (cause.title, cause.see, cause.why, cause.fix, cause.found):
            assert text.strip() == text
            assert len(text) > 8
        assert cause.see.endswith(".")
        assert cause.why.endswith(".")
        assert cause.found.endswith(".")
        assert not cause.fix.endswith(".")
        assert not cause.undo.endswith(".")


def test_what_explains_others_ranks_before_them() -> None:
    rank = {cause.id: cause.rank for cause in CAUSES}
    chain = ("cell-in-use", "port-missing", "cable-out", "arm-silent", "arm-emergency-stop-panel",
             "arm-key-at-teach", "arm-right-held", "arm-servo-off", "gripper-no-power",
             "gripper-silent")  # fmt: skip
    assert [rank[one] for one in chain] == sorted(rank[one] for one in chain)
