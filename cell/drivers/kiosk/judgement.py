"""Whether a page shows what it shall, and if not, why and what to do."""

from __future__ import annotations

from dataclasses import dataclass

from cell.drivers.kiosk.messages import PageView, Show
from cell.drivers.kiosk.pages import PageState


@dataclass(frozen=True, slots=True)
class Complaint:
    """Why a page does not count.

    Attributes:
        problem: What is wrong, without the page's name.
        hint: What to do about it.
        is_late: Whether it may only be a matter of time.
    """

    problem: str
    hint: str
    is_late: bool = False


def view_complaint(view: PageView, width_px: int, height_px: int) -> Complaint | None:
    """Return what is wrong with a page's window, or None.

    Pictures are shown pixel by pixel: the window must have exactly the panel's size, and
    neither desktop nor browser may scale.
    """
    if not view.is_visible:
        return Complaint(
            "is hidden: another tab or window is in front, or it is minimised",
            "bring the page to the front on the television's computer",
        )
    if view.pixel_ratio != 1.0:
        return Complaint(
            f"is scaled by {view.pixel_ratio:g}, so pixels would be blurred",
            "set the browser's zoom (Ctrl+0) and the desktop's scaling to 100 %",
        )
    if view.window_px == (width_px, height_px):
        return None
    got = "{} x {}".format(*view.window_px)
    wanted = f"{width_px} x {height_px}"
    if view.screen_px != (width_px, height_px):
        screen = "{} x {}".format(*view.screen_px)
        return Complaint(
            f"has {got} pixels on a screen of {screen}, {wanted} are needed",
            f"set the computer's output to {wanted} and move the page to the television",
        )
    return Complaint(
        f"has {got} pixels, {wanted} are needed",
        "click into the page (or press F11) to make it full screen",
    )


def picture_complaint(
    state: PageState, show: Show, width_px: int, height_px: int
) -> Complaint | None:
    """Return why a page does not show the picture, or None when it confirmed exactly that."""
    if state.view is None:
        return Complaint("is connected and says nothing", "reload the page (Ctrl+Shift+R)")
    wrong_view = view_complaint(state.view, width_px, height_px)
    if wrong_view is not None:
        return wrong_view
    if state.failed is not None and state.failed.number == show.number:
        return Complaint(
            f"cannot show {show.name!r}: {state.failed.problem}", "reload the page (Ctrl+Shift+R)"
        )
    painted = state.painted
    if painted is None or painted.number != show.number:
        return _not_painted(state, show)
    if painted.sha256 != show.sha256 or painted.picture_px != (show.width_px, show.height_px):
        size = "{} x {}".format(*painted.picture_px)
        return Complaint(
            f"shows other content under the name {show.name!r} "
            f"({painted.sha256[:12]}, {size}, instead of {show.sha256[:12]}, "
            f"{show.width_px} x {show.height_px})",
            "reload the page (Ctrl+Shift+R); is a proxy between it and the cell?",
        )
    return None


def _not_painted(state: PageState, show: Show) -> Complaint:
    if state.loading == show.number:
        return Complaint(
            f"has begun to load {show.name!r} and has not painted it",
            "see whether the television's computer is busy or its screen asleep",
            is_late=True,
        )
    return Complaint(
        f"does not react to {show.name!r}",
        "see whether the browser hangs, and reload the page",
        is_late=True,
    )
