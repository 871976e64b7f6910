"""`cell demo`: the whole thing in a minute, over a real socket, with proof."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from console.exits import Exit
from console.options import AsJson, TwinWiresOption
from console.output import put, put_json, say, styled
from console.places import pictures_folder, recordings_folder

if TYPE_CHECKING:
    from cell.assembly.wires import TwinWires
    from console.episodes import Episode
    from sessions.client import ActionReply, MasClient, View

_GOAL = "ReachRedCube"
_ENVIRONMENT = "STATIC_12x12"
_SCRIPT = "mash"
_PROFILE = "mash"


def demo(*, seed: int = 1, wires: TwinWiresOption = "memory", as_json: AsJson = False) -> int:
    """Play a whole experiment on the twin, record it, and prove that it repeats.

    Serves the shipped script on a cell of its own, plays ReachRedCube in STATIC_12x12 over
    a TCP socket by the teacher's actions, writes the recording and a picture of each camera,
    and replays the recording on a fresh twin.

    Args:
        seed: Seed of the session.
        wires: How drivers reach the emulated devices: joined in memory, or through
            pseudo-terminals that are opened like ports.
        as_json: Write JSON for programs.
    """
    from console.sessions import put_report
    from sessions.recording import SessionRecording
    from sessions.verify import verify

    with tempfile.TemporaryDirectory(prefix="robocell-demo-") as state:
        path, episode, pictures = _serve_and_play(Path(state), seed, wires)
    say(f"recorded {path} ({path.stat().st_size / 1e6:.1f} MB); replaying it on a fresh twin ...")
    report = verify(SessionRecording.open(path))
    is_done = report.is_identical and episode.outcome == "finished"
    if as_json:
        put_json(
            {
                "outcome": episode.outcome,
                "wires": wires,
                "steps": episode.steps,
                "steps_per_s": episode.steps_per_s,
                "reward": episode.reward,
                "actions": episode.actions,
                "rewards": episode.rewards,
                "session": str(path),
                "pictures": [str(picture) for picture in pictures],
                "verify": report.as_json(),
            }
        )
    else:
        put_report(report)
        put(f"session   {path}")
        for picture in pictures:
            put(f"picture   {picture}")
        say(_next_steps(path.stem))
    return Exit.DONE if is_done else Exit.FAILED


def _serve_and_play(state: Path, seed: int, wires: TwinWires) -> tuple[Path, Episode, list[Path]]:
    """Serve a fresh cell, play against it, and return recording, episode and pictures."""
    from cell.clock import SimulatedClock
    from cell.profile import parse_profile, profile_text
    from console.scripts import load_script
    from sessions.hosting import host_twin
    from sessions.server import Listener, MasServer

    text = profile_text(_PROFILE)
    profile = parse_profile(text, _PROFILE)
    before = set(recordings_folder().glob("*.mcap"))
    hosted = host_twin(
        load_script(_SCRIPT),
        profile,
        text,
        seed=seed,
        clock=SimulatedClock(),
        state_folder=state,
        recordings=recordings_folder(),
        wires=wires,
    )
    try:
        listener = Listener("127.0.0.1", 0, profile.server.dialect)
        server = MasServer(hosted.desk, [listener], ready=_announce)
        with server:
            episode, views = _play(server.addresses[0].host, server.addresses[0].port)
    finally:
        hosted.close()
    (path,) = set(recordings_folder().glob("*.mcap")) - before
    return path, episode, _write(views, pictures_folder(path.stem))


def _play(host: str, port: int) -> tuple[Episode, dict[str, View]]:
    from console.episodes import Choices, TeacherPolicy, play_episode
    from sessions.client import MasClient

    teacher = TeacherPolicy()
    views: dict[str, View] = {}

    def keep(step: int, view: View) -> None:
        views[view.name] = view

    with MasClient.connect(host, port) as client:
        _say_who(client)
        say("laying the blocks out ...")
        choices = Choices.begin(client, _GOAL, _ENVIRONMENT, None, teacher)
        episode = play_episode(
            client,
            choices,
            teacher,
            number=1,
            with_views=True,
            max_steps=100,
            on_step=_say_step,
            on_view=keep,
        )
        say("bringing the blocks home ...")
    say(
        f"{episode.outcome}: {episode.steps} steps, reward {episode.reward:g}, "
        f"{episode.view_bytes / 1e6:.0f} MB of views, {episode.steps_per_s:.0f} steps/s",
        "green" if episode.outcome == "finished" else "red",
    )
    return episode, views


def _announce(listeners: object) -> None:
    """The demo's own server needs no announcement."""


def _say_who(client: MasClient) -> None:
    info = client.info()
    say(f"connected to {info.type} {info.subtype}, MAS {info.protocol}; {_GOAL} in {_ENVIRONMENT}")


def _say_step(number: int, action: str, reply: ActionReply) -> None:
    say(f"  step {number:3d}  {action:6}  reward {reply.reward:4g}  {reply.event}")


def _write(views: dict[str, View], folder: Path) -> list[Path]:
    """Write the last picture of each camera as PNG."""
    from sessions.views import encode_png

    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, view in views.items():
        path = folder / f"{name.lower()}.png"
        path.write_bytes(encode_png(view.pixels()))
        paths.append(path)
    return paths


def _next_steps(session: str) -> str:
    cell = _own_call()
    lines = (
        (f"{cell} serve mash", "serve the shipped tasks to your own client"),
        (f"{cell} experiment 127.0.0.1:10993 --views", "play them from another shell"),
        (f"{cell} play 127.0.0.1:10993", "drive the arm with the arrow keys"),
        (f"{cell} sessions show {session}", "read what was said just now"),
        (f"{cell} sessions views {session}", "take every picture out of the recording"),
    )
    width = max(len(call) for call, _ in lines)
    listed = "\n".join(f"  {call:{width}}  {what}" for call, what in lines)
    return f"{styled('next:', 'bold', sys.stderr)}\n{listed}"


def _own_call() -> str:
    """Return how this program was called, so that the next calls can be copied."""
    called = Path(sys.argv[0])
    return str(called) if called.name == "cell" and called.parent != Path(".") else "cell"
