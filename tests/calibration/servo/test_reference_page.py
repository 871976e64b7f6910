from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "calibration-arms.md"
EXAMPLES = re.findall(r"^```python\n(.*?)^```", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE)


def test_the_examples_of_the_page_do_what_they_say() -> None:
    found: dict[str, tuple[float, ...]] = {}
    for example in EXAMPLES:
        exec(compile(example, PAGE.name, "exec"), found)  # noqa: S102
    assert len(EXAMPLES) == 2
    assert found["reached"] == pytest.approx((10, 20, 15, 30, 0), abs=1e-6)
    assert found["command"] != pytest.approx((10, 20, 15, 30, 0), abs=0.5)
