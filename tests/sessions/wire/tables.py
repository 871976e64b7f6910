"""One table of commands and one of replies, used in both directions."""

from __future__ import annotations

from hypothesis import settings

from sessions.wire import commands as c
from sessions.wire import replies as r

STEADY = settings(deadline=None, derandomize=True)
ALL = ("1.2", "1.3", "1.4", "1.5")
NEWER = ("1.3", "1.4", "1.5")
ON_REQUEST = ("1.3", "1.5")

COMMANDS: tuple[tuple[bytes, c.Command, tuple[str, ...]], ...] = (
    (b"STATUS", c.Status(), ALL),
    (b"INFO", c.Info(), ALL),
    (b"DONE", c.Done(), ALL),
    (b"SLEEP", c.Sleep(), NEWER),
    (b"LOGS", c.Logs(), NEWER),
    (b"USE_GLOBAL_SEED 0", c.UseGlobalSeed(0), NEWER),
    (b"USE_GLOBAL_SEED 4294967295", c.UseGlobalSeed(4294967295), NEWER),
    (b"LIST_GOALS", c.ListGoals(), ALL),
    (b"LIST_ENVIRONMENTS ReachRedCube.Random", c.ListEnvironments("ReachRedCube.Random"), ALL),
    (b"LIST_ENVIRONMENTS 'Reach it'", c.ListEnvironments("Reach it"), ALL),
    (b"INITIALIZE_TASK A STATIC_4x4", c.InitializeTask("A", "STATIC_4x4"), ALL),
    (b"BEGIN_TASK_SETUP", c.BeginTaskSetup(), ALL),
    (b"END_TASK_SETUP", c.EndTaskSetup(), ALL),
    (b"TEACHING ON", c.Teaching(True), ON_REQUEST),
    (b"TEACHING OFF", c.Teaching(False), ON_REQUEST),
    (b"RESET_TASK", c.ResetTask(), ALL),
    (b"GET_VIEW CAMERA_TOP", c.GetView("CAMERA_TOP"), ALL),
    (b"ACTION UP", c.Action("UP"), ALL),
    (b"ACTION 'it\\'s\\nup'", c.Action("it's\nup"), ALL),
    (b"ACTION ''", c.Action(""), ALL),
    (b"ACTION \xc3\xa9t\xc3\xa9", c.Action("été"), ALL),
    (b"ACTION a\\nb", c.Action("a\\nb"), ALL),
    (b"ACTION 'a \\b'", c.Action("a \\b"), ALL),
    (b"RESET", c.Reset(), NEWER),
    (b"GET_TRAJECTORIES_COUNT", c.GetTrajectoriesCount(), ("1.4",)),
    (b"GET_TRAJECTORY_LENGTH 7", c.GetTrajectoryLength(7), ("1.4",)),
)

VIEW = bytes(range(200)) + b"\n\r\nREADY\n"

REPLIES: tuple[tuple[bytes, r.Answer, tuple[str, ...]], ...] = (
    (b"READY\n", r.Ready(), ALL),
    (b"BUSY\n", r.Busy(), ALL),
    (b"OK\n", r.Ok(), ALL),
    (b"GOODBYE\n", r.Goodbye(), ALL),
    (
        b"TYPE ApplicationServer\nSUBTYPE Interactive\nPROTOCOL 1.4\n",
        r.ServerInfo("ApplicationServer", "Interactive", "1.4"),
        ALL,
    ),
    (b"END_LOGS\n", r.LogFiles(()), NEWER),
    (
        b"LOG_FILE session.log 8\nseed 1\n\nLOG_FILE 'b c' 0\nEND_LOGS\n",
        r.LogFiles((r.LogFile("session.log", b"seed 1\n\n"), r.LogFile("b c", b""))),
        NEWER,
    ),
    (b"END_LIST_GOALS\n", r.Goals(()), ALL),
    (b"GOAL A\nGOAL A.Random\nEND_LIST_GOALS\n", r.Goals(("A", "A.Random")), ALL),
    (b"END_LIST_ENVIRONMENTS\n", r.Environments(()), ALL),
    (b"ENVIRONMENT S\nEND_LIST_ENVIRONMENTS\n", r.Environments(("S",)), ALL),
    (
        b"AVAILABLE_ACTIONS UP DOWN\nAVAILABLE_VIEWS T:640x480 G:1280x960\n",
        r.TaskOffer(("UP", "DOWN"), (r.OfferedView("T", 640, 480), r.OfferedView("G", 1280, 960))),
        ("1.2", "1.3", "1.5"),
    ),
    (
        b"AVAILABLE_ACTIONS UP\nAVAILABLE_VIEWS\nMODE TEACHER\n",
        r.TaskOffer(("UP",), (), "TEACHER"),
        ("1.4",),
    ),
    (b"STATE_UPDATED\n", r.StateUpdated(), ALL),
    (b"SUGGESTED_ACTION UP\nSTATE_UPDATED\n", r.StateUpdated("UP"), ("1.4",)),
    (b"REWARD 0\nSTATE_UPDATED\n", r.ActionDone(0.0), ALL),
    (b"REWARD 0.25\nFINISHED\n", r.ActionDone(0.25, state="FINISHED"), ALL),
    (b"REWARD -10\nFAILED\n", r.ActionDone(-10.0, state="FAILED"), ("1.3", "1.4")),
    (b"REWARD 0\nEVENT Robot move\nSTATE_UPDATED\n", r.ActionDone(0.0, "Robot move"), ("1.2",)),
    (b"REWARD 0\nEVENT it's\nSTATE_UPDATED\n", r.ActionDone(0.0, "it's"), ("1.2",)),
    (b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n", r.ActionDone(0.0, "Robot move"), NEWER),
    (b"REWARD 0\nEVENT moved\nSTATE_UPDATED\n", r.ActionDone(0.0, "moved"), ALL),
    (
        b"REWARD 20\nEVENT 'it\\'s\\nhere'\nFINISHED\n",
        r.ActionDone(20.0, "it's\nhere", state="FINISHED"),
        NEWER,
    ),
    (
        b"REWARD 0\nEVENT 'Robot move'\nTEACHER_ACTION UP\nSTATE_UPDATED\n",
        r.ActionDone(0.0, "Robot move", "UP"),
        ON_REQUEST,
    ),
    (
        b"REWARD 0\nSUGGESTED_ACTION UP\nSTATE_UPDATED\n",
        r.ActionDone(0.0, suggestion="UP"),
        ("1.4",),
    ),
    (b"VIEW CAMERA_TOP image/mif 209\n" + VIEW, r.ViewData("CAMERA_TOP", "image/mif", VIEW), ALL),
    (b"NB_TRAJECTORIES 0\n", r.TrajectoriesCount(0), ("1.4",)),
    (b"TRAJECTORY_LENGTH 12\n", r.TrajectoryLength(12), ("1.4",)),
    (b"GLOBAL_SEED_ALREADY_SET\n", r.GlobalSeedAlreadySet(), NEWER),
    (b"NOT_SUPPORTED\n", r.NotSupported(), ON_REQUEST),
    (b"NO_TASK_SELECTED\n", r.NoTaskSelected(), ALL),
    (b"UNKNOWN_GOAL X\n", r.UnknownGoal("X"), ALL),
    (b"UNKNOWN_ENVIRONMENT 'a b'\n", r.UnknownEnvironment("a b"), ALL),
    (b"UNKNOWN_VIEW ''\n", r.UnknownView(""), ALL),
    (b"UNKNOWN_ACTION 'o\\'clock'\n", r.UnknownAction("o'clock"), ALL),
    (b"UNKNOWN_TRAJECTORY 3\n", r.UnknownTrajectory(3), ("1.4",)),
    (b"UNKNOWN_COMMAND status\n", r.UnknownCommand("status"), ALL),
    (b"INVALID_ARGUMENTS\n", r.InvalidArguments(b""), ALL),
    (b"INVALID_ARGUMENTS  \xff 'x\n", r.InvalidArguments(b" \xff 'x"), ALL),
    (
        b"ERROR 'Task setup already started'\n",
        r.Failure("Task setup already started"),
        ALL,
    ),
)
