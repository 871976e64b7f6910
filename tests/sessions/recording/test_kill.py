"""What a killed process leaves behind."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sessions.recording import SessionRecording, list_recordings

REPOSITORY = Path(__file__).parents[3]
CHILD = """
import sys
from pathlib import Path
from tests.sessions.recording.samples import a_bench, a_frame

bench = a_bench(Path(sys.argv[1]))
for number in range(1, 1_000_000):
    bench.step(number)
    bench.view(a_frame(number, width=320, height=240))
    sys.stdout.write(f"{number}\\n")
    sys.stdout.flush()
"""


@pytest.mark.parametrize("seed", range(6))
def test_no_step_whose_reply_left_is_missing_after_kill_9(tmp_path: Path, seed: int) -> None:
    moment = random.Random(seed).randrange(1, 400)
    with subprocess.Popen(
        [sys.executable, "-c", CHILD, str(tmp_path)],
        cwd=REPOSITORY,
        stdout=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stdout is not None
        for line in child.stdout:
            if int(line) == moment:
                break
        child.send_signal(signal.SIGKILL)
        rest = child.stdout.read().splitlines()
    said = int(rest[-1]) if rest else moment
    (summary,) = list_recordings(tmp_path)
    assert summary.state == "not finished"
    recording = SessionRecording.open(summary.path)
    steps = [step for step in recording.steps() if step.reply is not None]
    moves = [step for step in steps if step.line == b"ACTION RIGHT"]
    assert len(moves) >= said
    assert len([step for step in steps if step.view is not None]) >= said
    hashes = recording.view_hashes()
    unwritten = [s.view.view for s in steps if s.view is not None and s.view.view not in hashes]
    assert len(unwritten) <= 8, "only views that waited in the queue may be missing"
    assert unwritten == sorted(unwritten)
    assert not unwritten or min(unwritten) > max(hashes, default=0)
