from __future__ import annotations

import pytest

from tests.transcripts.dialogue import FOLDER, combinations, mash_script, transcript_path
from tests.transcripts.generate import transcripts


@pytest.fixture(scope="module")
def played() -> dict[tuple[str, str, str], str]:
    return transcripts()


def test_there_is_a_transcript_of_each_goal_environment_and_dialect_and_no_other() -> None:
    wanted = {transcript_path(*names) for names in combinations(mash_script())}

    assert len(wanted) == 2 * 4 * 4
    assert set((FOLDER / "mash").iterdir()) == wanted


@pytest.mark.parametrize("names", list(combinations(mash_script())), ids="-".join)
def test_the_dialogue_is_as_its_golden_transcript(
    names: tuple[str, str, str], played: dict[tuple[str, str, str], str]
) -> None:
    assert played[names] == transcript_path(*names).read_text("utf-8")
