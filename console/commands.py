"""The commands there are: name, where each is, what it does in a line.

The modules are imported only when their command runs, so that `cell --help`
costs little more than the start of the interpreter.
"""

from __future__ import annotations

from typing import Final, NamedTuple


class Command(NamedTuple):
    """One command.

    Attributes:
        name: What is typed after `cell`.
        arguments: What usually follows it, for the overview.
        target: Module and name of the function or group, as `module:name`.
        summary: What it does.
    """

    name: str
    arguments: str
    target: str
    summary: str


COMMANDS: Final = (
    Command("demo", "", "console.demo:demo", "Play a whole experiment on the twin and verify it."),
    Command("serve", "SCRIPT", "console.serve:serve", "Serve a script to experiment clients."),
    Command("check", "SCRIPT", "console.check:check", "Check a script, also against a cell."),
    Command("play", "HOST:PORT", "console.play:play", "Drive the arm with keys."),
    Command(
        "experiment",
        "HOST:PORT",
        "console.experiment:experiment",
        "Play episodes by a policy; JSON result.",
    ),
    Command(
        "sessions",
        "list|show|verify|views",
        "console.sessions:app",
        "Look at recorded sessions, and prove that they repeat.",
    ),
    Command(
        "robot",
        "pose|joints|move|lattice|...",
        "console.robot:app",
        "The arm by hand, every motion through the guard.",
    ),
    Command(
        "gripper",
        "open|close|move|grip|...",
        "console.gripper:app",
        "The gripper by hand.",
    ),
    Command("tv", "on|off|input|picture|...", "console.tv:app", "The television by hand."),
    Command("lights", "on|off", "console.lights:lights", "The cell's lights by hand."),
    Command("camera", "list|grab|features|...", "console.camera:app", "The cameras by hand."),
    Command(
        "webcam",
        "still|watch|move|home|...",
        "console.webcam:app",
        "The web camera: its pictures and where it looks.",
    ),
    Command("tv-page", "", "console.tv_page:tv_page", "Serve the television's picture."),
    Command("store", "where|grip|release|...", "console.store:app", "Blocks by hand."),
    Command(
        "emulate",
        "[MODEL]",
        "console.emulate:emulate",
        "Run emulated devices behind ports, for any program.",
    ),
    Command("bringup", "", "console.bringup:bringup", "Bring the cell up step by step."),
    Command("doctor", "", "console.doctor:doctor", "Find out why the cell does not work."),
    Command(
        "calibrate",
        "[PROCEDURE]",
        "console.calibrate:calibrate",
        "Measure something of the cell and keep it.",
    ),
    Command(
        "calibration",
        "list|show|check|diff|undo",
        "console.calibration:app",
        "The kept calibrations: how good they are, whether they hold.",
    ),
    Command("clean", "", "console.clean:clean", "Bring every block back to the store."),
    Command(
        "watchdog",
        "run|history|reports|send",
        "console.watchdog:app",
        "Test every component; see faults and reports.",
    ),
    Command(
        "profile",
        "new|check|show|diff|list",
        "console.profile:app",
        "Write, check, show and compare the profiles of cells.",
    ),
)
"""In the order of the overview."""


def overview() -> str:
    """Return the help of `cell` itself."""
    calls = [f"{command.name} {command.arguments}".strip() for command in COMMANDS]
    width = max(len(call) for call in calls)
    listed = "\n".join(
        f"  {call:{width}}  {command.summary}"
        for call, command in zip(calls, COMMANDS, strict=True)
    )
    return (
        "Usage: cell COMMAND [OPTIONS]\n\n"
        "Small research robot cells: serve tasks, record them, replay them.\n\n"
        f"Commands:\n{listed}\n\n"
        "  cell COMMAND --help says more; cell --version prints the version.\n"
        "Begin with `cell demo`.\n"
    )
