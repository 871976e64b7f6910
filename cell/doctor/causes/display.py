"""What can be wrong with the television, its picture and the lights."""

from __future__ import annotations

from cell.doctor.findings import Cause

_TV = "Television"
_LIGHT = "Lights"

DISPLAY: tuple[Cause, ...] = (
    Cause(
        id="tv-silent",
        title="The television is asleep or has no mains",
        group=_TV,
        rank=45,
        see="The television does not answer and stays dark.",
        why="Its power switch is off, or it was unplugged: then its serial port sleeps until it "
        "was switched on by hand once.",
        fix="switch the set on at its power switch and once with its own key; the cell then gives "
        "the permission to wake it",
        found="The line can be used, and the set answers no question, not even the link check.",
    ),
    Cause(
        id="tv-standby",
        title="The television is in standby in the middle of work",
        group=_TV,
        rank=47,
        see="The playground is dark.",
        why="Somebody used the remote control, or the set's own timer did.",
        fix="switch it on: `cell tv on`",
        found="The set says that it is off while the cell is in service.",
    ),
    Cause(
        id="tv-wrong-input",
        title="The television shows another input",
        group=_TV,
        rank=48,
        see="The playground shows television, or says that there is no signal.",
        why="Somebody used the remote control, or the cable sits in another socket.",
        fix="select the input of the profile, or correct display.input",
        found="The set tells which input it shows.",
        undo="select the old input",
    ),
    Cause(
        id="tv-no-permission",
        title="The television may not be woken over its line",
        group=_TV,
        rank=60,
        see="It works today; after the next switching off it stays asleep.",
        why="The set forgets the permission when it is without mains.",
        fix="switch it on once through the cell, which gives the permission: `cell tv on`",
        found="The set tells whence it may be switched on (RSPW).",
    ),
    Cause(
        id="tv-sleep-timer",
        title="The television will switch itself off",
        group=_TV,
        rank=61,
        see="In the middle of a session the playground goes dark.",
        why="Its sleep timer runs.",
        fix="switch the sleep timer off with the remote control",
        found="The set tells its sleep timer (OFTM).",
        undo="set the timer again",
    ),
    Cause(
        id="page-not-connected",
        title="The picture page is not open",
        group=_TV,
        rank=49,
        see="The playground shows the desktop or nothing.",
        why="The browser on the television's computer is closed, or shows another page.",
        fix="open the page full-screen on the television: `cell tv-page`",
        found="The page server has no page connected.",
    ),
    Cause(
        id="page-wrong-size",
        title="The picture page has the wrong size",
        group=_TV,
        rank=50,
        see="The picture has borders; the lattice does not fit.",
        why="The browser is not full-screen, is zoomed, or the screen has another resolution.",
        fix="make the browser full-screen at 100 %, and set the screen to the panel's resolution",
        found="The page tells the pixels that it covers.",
    ),
)

LIGHTS: tuple[Cause, ...] = (
    Cause(
        id="lights-off",
        title="The lights are off in the middle of work",
        group=_LIGHT,
        rank=51,
        see="Pictures are dark.",
        why="The output was switched off, by hand or by another program.",
        fix="switch them on: `cell lights on`",
        found="The output of the lights reads off while the cell is in service.",
        undo="switch them off again",
    ),
    Cause(
        id="lamp-dead",
        title="The lamps stay dark",
        group=_LIGHT,
        rank=52,
        see="Pictures are dark although the lights are on.",
        why="A lamp or its fuse is dead, or the wrong output is switched.",
        fix="look at the lamps; check their fuse and outputs.lights",
        found="The output of the lights reads on, and every camera's picture stays dark.",
    ),
)
