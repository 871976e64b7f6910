"""`cell tv-page`: the television's picture, served until somebody stops it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter, validators

from console.exits import ConsoleError, Exit
from console.options import ProfileName
from console.output import put, say
from console.places import cell_folder
from console.signals import signals_handled

if TYPE_CHECKING:
    from cell.drivers.kiosk import KioskScreen

_LOOK_S = 0.2


def tv_page(
    *,
    picture: Annotated[
        str | None,
        Parameter(help="Picture to show: black, white, mash, water, forest; the last one else."),
    ] = None,
    port: Annotated[int | None, Parameter(validator=validators.Number(gte=0, lte=65535))] = None,
    profile: ProfileName = "mash",
) -> int:
    """Serve the page that the television shows, and tell what is on it.

    Writes the page's address to stdout as soon as a browser can open it. Every change is
    told on stderr: a page comes or goes, a picture is painted, a window is hidden or has
    the wrong size. Ctrl-C or SIGTERM ends it; the page keeps its picture and connects
    again to the next program that serves it.

    Args:
        picture: Name of the picture.
        port: Port of the page, 0 for a free one; the profile's unless given.
        profile: Profile of the cell, for the size of its television.
    """
    from cell.drivers.kiosk import KioskScreen, KioskSettings
    from cell.pictures import PICTURE_NAMES
    from cell.profile import load_profile

    if picture is not None and picture not in PICTURE_NAMES:
        known = ", ".join(PICTURE_NAMES)
        raise ConsoleError(f"there is no picture {picture!r}; there are {known}")
    used = load_profile(profile)
    folder = cell_folder(used.name)
    settings = KioskSettings.from_profile(used.display, port=port, state_folder=folder)
    with _stopping() as received, KioskScreen(settings) as screen:
        put(screen.url)
        say(f"open {screen.url} on the television's computer and click it for full screen", "dim")
        if picture is not None:
            screen.send(picture)
        _tell_changes(screen, received)
    return Exit.INTERRUPTED if signal.SIGINT in received else Exit.DONE


def _tell_changes(screen: KioskScreen, received: list[int]) -> None:
    """Tell what is on the screen whenever that changes, until a signal comes.

    A trouble is told when it lasts: a page that has just come has said nothing yet.
    """
    seen, told = 0, ""
    while not received:
        before = seen
        seen, _ = screen.await_change(before, _LOOK_S)
        trouble = _trouble(screen)
        state = trouble or _picture(screen)
        if state != told and (not trouble or seen == before):
            say(state)
            told = state


def _trouble(screen: KioskScreen) -> str:
    """Return why the picture is not on the screen, or an empty text."""
    from cell.errors import DeviceError

    try:
        screen.check()
    except DeviceError as error:
        return str(error)
    return ""


def _picture(screen: KioskScreen) -> str:
    """Return what is on the screen."""
    painted = screen.painted()
    if not screen.shown() or not painted:
        return "screen: a page is connected and waits for a picture"
    width_px, height_px = painted[0].picture_px
    took_ms = max(page.took_ms for page in painted)
    pages = "1 page" if len(painted) == 1 else f"{len(painted)} pages"
    return (
        f"screen: {screen.shown()} is painted, {width_px} x {height_px}, {pages}, "
        f"{took_ms:.0f} ms after it was sent, content {painted[0].sha256[:12]}"
    )


@contextmanager
def _stopping() -> Iterator[list[int]]:
    """Collect SIGTERM and SIGINT for a while."""
    received: list[int] = []

    def stop(number: int, frame: FrameType | None) -> None:
        received.append(number)

    with signals_handled(stop):
        yield received
