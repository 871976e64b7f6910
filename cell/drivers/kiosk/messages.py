"""What server and page say to each other over the WebSocket, as JSON, without I/O.

Server to page: `show` (a number, a name, an address, its SHA-256, its size).
Page to server: `view` (window and screen, at the start and whenever they change),
`loading`, `painted` and `failed` (each with the number of the `show` it answers).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from cell.errors import CellError

MOST_BYTES = 4096
"""Longest message that a page may send."""

_Text = Annotated[str, Field(max_length=400)]
_Count = Annotated[int, Field(ge=0)]
_Size = tuple[_Count, _Count]


class MalformedMessage(CellError):
    """A message is none that a page sends."""


class _Message(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PageView(_Message):
    """What a page knows of its window and its screen."""

    window_px: _Size
    """Width and height of the window's inside, in CSS pixels."""
    pixel_ratio: Annotated[float, Field(gt=0)]
    """Screen pixels to a CSS pixel; 1 unless the desktop or the browser scales."""
    screen_px: _Size
    """Width and height of the whole screen, in CSS pixels."""
    is_visible: bool
    """Whether any of the page can be seen, as far as the browser knows."""
    is_fullscreen: bool
    browser: _Text = ""

    @property
    def covers_px(self) -> tuple[int, int]:
        """Width and height of the window's inside, in pixels of the screen."""
        width_px, height_px = self.window_px
        return round(width_px * self.pixel_ratio), round(height_px * self.pixel_ratio)


class Viewed(_Message):
    """The page is there, or its window has changed."""

    kind: Literal["view"]
    view: PageView


class Loading(_Message):
    """The page has been told and is fetching the picture."""

    kind: Literal["loading"]
    number: _Count


class Painted(_Message):
    """A picture is on the page.

    Sent after the decoded picture has been part of a frame that the browser finished
    (the second animation frame after it was put in place).
    """

    kind: Literal["painted"]
    number: _Count
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    """Of the file's bytes, reckoned by the page from what it received."""
    picture_px: _Size
    """Width and height of the decoded picture."""
    painted_unix_ms: float
    """When, by the clock of the page's computer."""
    took_ms: Annotated[float, Field(ge=0)]
    """From the message's arrival at the page until it was painted."""
    view: PageView


class Failed(_Message):
    """The page cannot show a picture."""

    kind: Literal["failed"]
    number: _Count
    problem: _Text


PageMessage: TypeAlias = Viewed | Loading | Painted | Failed

_MESSAGES: TypeAdapter[PageMessage] = TypeAdapter(
    Annotated[PageMessage, Field(discriminator="kind")]
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Show:
    """Tells a page to show a picture.

    Attributes:
        number: Counts what was shown; the page's answers name it.
        name: Name of the picture, for people.
        sha256: SHA-256 of the PNG file.
        width_px: Width of the picture.
        height_px: Height of the picture.
    """

    number: int
    name: str
    sha256: str
    width_px: int
    height_px: int


def picture_path(sha256: str) -> str:
    """Return where the server has the picture with that content."""
    return f"/pictures/{sha256}.png"


def encode_show(show: Show) -> str:
    """Return the message that has a page show a picture."""
    return json.dumps(
        {
            "kind": "show",
            "number": show.number,
            "name": show.name,
            "path": picture_path(show.sha256),
            "sha256": show.sha256,
            "width_px": show.width_px,
            "height_px": show.height_px,
        }
    )


def decode_message(text: str | bytes) -> PageMessage:
    """Return what a page said.

    Raises:
        MalformedMessage: It is nothing that a page says.
    """
    try:
        return _MESSAGES.validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "message"
        raise MalformedMessage(f"the page sent nonsense: {where}: {first['msg']}") from None
