"""What the emulated web camera answers to ptz.cgi and param.cgi."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from cell.drivers.axis_vapix.tables import DIRECTIONS, LENS, PERCENT, SPEED, Span
from cell.errors import CellError
from cell.twin.emulators.axis_vapix.head import Head, angle_of_view_deg
from cell.twin.emulators.axis_vapix.settings import EmulatedAxisSettings

Query = Mapping[str, str]


class Mistake(CellError):
    """The request is wrong; the text is what the camera says."""


class HeadAnswers:
    """Does what ptz.cgi is asked and says what it says; None is an empty answer (204)."""

    def __init__(self, head: Head, settings: EmulatedAxisSettings) -> None:
        self._head = head
        self._settings = settings

    def answer(self, query: Query) -> str | None:
        """Return the text of an answer, or None for one without.

        Raises:
            Mistake: The request is none that the camera has, or a value is wrong.
        """
        if not self._settings.has_head_driver:
            raise Mistake("No PTZ driver installed")
        if "query" in query:
            return self._tell(query["query"])
        if "whoami" in query:
            return "AXIS PTZ camera driver\r\n"
        done = [act(query) for act in self._acts()]
        if not any(done):
            raise Mistake(f"unknown request {'&'.join(query)}")
        return None

    def _acts(self) -> tuple[Callable[[Query], bool], ...]:
        return (self._point, self._turn, self._step, self._sweep, self._centre, self._recall,
                self._set_lens)  # fmt: skip

    def _tell(self, what: str) -> str:
        if what == "position":
            state = self._head.state()
            lines = [
                f"pan={state.pan_deg:.2f}",
                f"tilt={state.tilt_deg:.2f}",
                f"zoom={state.zoom:.0f}",
                f"iris={state.iris:.0f}",
                f"focus={state.focus:.0f}",
                f"brightness={state.brightness:.0f}",
                f"autofocus={'on' if state.has_autofocus else 'off'}",
                f"autoiris={'on' if state.has_autoiris else 'off'}",
            ]
        elif what == "limits":
            spans = {
                "Pan": self._settings.pan_deg,
                "Tilt": self._settings.tilt_deg,
                "Zoom": (LENS.least, LENS.most),
                "Focus": (LENS.least, LENS.most),
                "Iris": (LENS.least, LENS.most),
            }
            lines = [
                f"{word}{name}={value:g}"
                for name, span in spans.items()
                for word, value in zip(("Min", "Max"), span, strict=True)
            ]
        elif what == "speed":
            lines = ["speed=100"]
        elif what == "presetposall":
            names = enumerate(self._settings.presets, start=1)
            lines = ["Preset Positions for camera 1"]
            lines += [f"presetposno{number}={name}" for number, name in names]
        else:
            raise Mistake(f"unknown query {what}")
        return "".join(f"{line}\r\n" for line in lines)

    def _point(self, query: Query) -> bool:
        if not query.keys() & {"pan", "tilt", "zoom"}:
            return False
        self._head.go_to(
            pan_deg=_maybe(query, "pan", Span(-180, 180)),
            tilt_deg=_maybe(query, "tilt", Span(-180, 180)),
            zoom=_maybe(query, "zoom", LENS),
            speed_percent=_speed(query),
        )
        return True

    def _turn(self, query: Query) -> bool:
        if not query.keys() & {"rpan", "rtilt", "rzoom"}:
            return False
        self._head.go_by(
            pan_deg=_maybe(query, "rpan", Span(-360, 360)) or 0.0,
            tilt_deg=_maybe(query, "rtilt", Span(-360, 360)) or 0.0,
            zoom=_maybe(query, "rzoom", Span(-9999, 9999)) or 0.0,
            speed_percent=_speed(query),
        )
        return True

    def _step(self, query: Query) -> bool:
        move = query.get("move")
        if move is None:
            return False
        if move == "home":
            self._head.go_to(pan_deg=0.0, tilt_deg=0.0, zoom=1.0)
        elif move == "stop":
            self._head.stop()
        else:
            direction = next((known for known in DIRECTIONS if known == move), None)
            if direction is None:
                raise Mistake(f"unknown move {move}")
            self._head.step(direction)
        return True

    def _sweep(self, query: Query) -> bool:
        pair = query.get("continuouspantiltmove")
        zoom = _maybe(query, "continuouszoommove", PERCENT)
        focus = _maybe(query, "continuousfocusmove", PERCENT)
        if pair is None and zoom is None and focus is None:
            return False
        pan, tilt = (None, None) if pair is None else _pair(pair, "continuouspantiltmove", PERCENT)
        self._head.sweep(pan_percent=pan, tilt_percent=tilt, zoom_percent=zoom, focus_percent=focus)
        return True

    def _centre(self, query: Query) -> bool:
        if "center" not in query:
            return False
        column, row = _pair(query["center"], "center", Span(0, 8192))
        width = _maybe(query, "imagewidth", Span(1, 8192)) or 640.0
        height = _maybe(query, "imageheight", Span(1, 8192)) or 480.0
        scale = angle_of_view_deg(self._head.state(), self._settings) / width
        self._head.go_by(pan_deg=(column - width / 2) * scale, tilt_deg=(height / 2 - row) * scale)
        return True

    def _recall(self, query: Query) -> bool:
        name = query.get("gotoserverpresetname")
        if name is None:
            return False
        if name not in self._settings.presets:
            raise Mistake(f"no preset position {name}")
        pan_deg, tilt_deg, zoom = self._settings.presets[name]
        self._head.go_to(pan_deg=pan_deg, tilt_deg=tilt_deg, zoom=zoom)
        return True

    def _set_lens(self, query: Query) -> bool:
        known = {"focus", "iris", "brightness", "autofocus", "autoiris"}
        if not query.keys() & known:
            return False
        self._head.set_lens(
            focus=_maybe(query, "focus", LENS),
            iris=_maybe(query, "iris", LENS),
            brightness=_maybe(query, "brightness", LENS),
            has_autofocus=_switch(query, "autofocus"),
            has_autoiris=_switch(query, "autoiris"),
        )
        return True


def parameters(query: Query, settings: EmulatedAxisSettings) -> str:
    """Return what param.cgi lists.

    Raises:
        Mistake: It is asked for something else than a list.
    """
    if query.get("action") != "list":
        raise Mistake("only action=list is supported")
    known = {
        "root.Brand.Brand": "AXIS",
        "root.Brand.ProdFullName": settings.product,
        "root.Brand.ProdShortName": settings.product.removesuffix(" Network Camera"),
        "root.Image.I0.Appearance.Resolution": "640x480",
        "root.Properties.PTZ.PTZ": "yes" if settings.has_head else "no",
        "root.Properties.Firmware.Version": "4.47",
    }
    group = query.get("group", "")
    wanted = group if group.startswith("root") else f"root.{group}".rstrip(".")
    lines = [f"{name}={value}" for name, value in known.items() if name.startswith(wanted)]
    if not lines:
        raise Mistake(f"Error getting param in group '{group}'")
    return "".join(f"{line}\n" for line in lines)


def _maybe(query: Query, name: str, span: Span) -> float | None:
    text = query.get(name)
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        raise Mistake(f"{name} is no number") from None
    if not span.allows(value):
        raise Mistake(f"{name} is out of range")
    return value


def _pair(text: str, name: str, span: Span) -> tuple[float, float]:
    first, comma, second = text.partition(",")
    if not comma:
        raise Mistake(f"{name} needs two values")
    values = (_maybe({name: first}, name, span), _maybe({name: second}, name, span))
    return values[0] or 0.0, values[1] or 0.0


def _switch(query: Query, name: str) -> bool | None:
    text = query.get(name)
    if text is None:
        return None
    if text not in ("on", "off"):
        raise Mistake(f"{name} is on or off")
    return text == "on"


def _speed(query: Query) -> float:
    speed = _maybe(query, "speed", SPEED)
    return 100.0 if speed is None else speed
