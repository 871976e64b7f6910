"""The `views` statement."""

from __future__ import annotations

from dsl import nodes as n
from dsl.diagnostics import Report
from dsl.kinds import VIEW_FORMATS, VIEW_SIZES
from dsl.program import View
from dsl.words import did_you_mean, enumerate_words

_DEFAULT_FORMAT = VIEW_FORMATS[0]
_DEFAULT_SIZE = VIEW_SIZES[-1]


def check_views(node: n.ViewsNode, report: Report) -> tuple[View, ...]:
    """Return the views; one without `as` takes what the next one with it says."""
    found: dict[str, View] = {}
    described: n.ViewNode | None = None
    for view in reversed(node.views):
        described = view if view.is_described else described
        mime, size = _format(described, report), _size(described, report)
        if mime is not None and size is not None:
            found.setdefault(view.name.text, View(view.name.text, mime, *size, view.name.span))
    seen: set[str] = set()
    for view in node.views:
        if view.name.text in seen:
            message = f"the view {view.name.text} is in the list already"
            report.add("E204", view.name.span, message, "remove one")
        seen.add(view.name.text)
    return tuple(reversed(found.values()))


def _format(view: n.ViewNode | None, report: Report) -> str | None:
    if view is None or view.format is None:
        return f"image/{_DEFAULT_FORMAT}"
    name = view.format.text
    if name in VIEW_FORMATS:
        return f"image/{name}"
    hint = did_you_mean(name, VIEW_FORMATS)
    report.add("E304", view.format.span, f"there is no picture format {name}", hint)
    return None


def _size(view: n.ViewNode | None, report: Report) -> tuple[int, int] | None:
    if view is None or view.size is None:
        return _DEFAULT_SIZE
    wanted = (view.size.width, view.size.height)
    if wanted in VIEW_SIZES:
        return int(wanted[0]), int(wanted[1])
    offered = enumerate_words([f"{w}x{h}" for w, h in VIEW_SIZES], "and")
    message = f"no camera gives pictures of {wanted[0]:g}x{wanted[1]:g}"
    report.add("E303", view.size.span, message, f"there is {offered}")
    return None
