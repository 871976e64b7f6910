"""What a recording holds: topics, their layouts, and the version of it all.

The file is MCAP (https://mcap.dev/spec), unchunked, so that every record is whole
as soon as it is written. `docs/reference/recording.md` is the same in prose.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Final, Literal

FORMAT_VERSION: Final = 1
MCAP_PROFILE: Final = "robocell"

RECEIVED: Final = "client/received"
REPLIED: Final = "client/replied"
VIEW_SENT: Final = "client/view_sent"
EVENTS: Final = "events"
ENDED: Final = "session/ended"
WIRE_PREFIX: Final = "wire/"
VIEWS_PREFIX: Final = "views/"

SESSION_METADATA: Final = "session"
VERSIONS_METADATA: Final = "versions"
CALIBRATION_METADATA: Final = "calibration"
SCRIPT_FILE: Final = "script.cell"
PROFILE_FILE: Final = "profile.toml"
CALIBRATIONS_FILE: Final = "calibrations.json"
"""The records in force, whole; there only if there were any."""
IN_FORCE_PREFIX: Final = "in_force/"
WORLD_FILE: Final = "world.json"

REPLY_HEAD: Final = struct.Struct("<BQ")
"""Flags, number of bytes of binary data that followed the text."""
REPLY_CLOSES: Final = 1
REPLY_HAS_VIEW: Final = 2

PICTURE_HEAD: Final = struct.Struct("<I")
"""Length of the JSON that comes before the picture's bytes."""

WIRE_HEAD: Final = struct.Struct("<I")
"""Number of pieces in a message of wire traffic."""
WIRE_PIECE: Final = struct.Struct("<BdI")
"""Direction, time in s, number of bytes of a piece."""
TO_DEVICE: Final = 0
FROM_DEVICE: Final = 1

MessageEncoding = Literal["json", "octets"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SchemaText:
    """What a channel's messages look like.

    Attributes:
        name: Name of the schema.
        encoding: `jsonschema`, or `text` for a layout told in words.
        text: The schema.
    """

    name: str
    encoding: Literal["jsonschema", "text"]
    text: str

    @property
    def message_encoding(self) -> MessageEncoding:
        """How messages of this schema are encoded."""
        return "json" if self.encoding == "jsonschema" else "octets"


LINE_SCHEMA: Final = SchemaText(
    name="robocell.ClientLine",
    encoding="text",
    text="The bytes of one line as the client sent it, without its LF.\n",
)
REPLY_SCHEMA: Final = SchemaText(
    name="robocell.Reply",
    encoding="text",
    text=(
        "uint8 flags: 1 the connection was closed after it, 2 its data is a view\n"
        "uint64 little-endian: number of bytes of binary data that followed the text\n"
        "the rest: the reply's lines, each with its LF. The data itself is not here: of a view,\n"
        "the message of the same sequence in client/view_sent names the record in views/*.\n"
    ),
)
WIRE_SCHEMA: Final = SchemaText(
    name="robocell.WireBytes",
    encoding="text",
    text=(
        "Traffic in a row with one device. uint32: number of pieces; for each piece uint8\n"
        "direction (0 to the device, 1 from the device), float64 time in s on the session's\n"
        "clock, uint32 number of bytes; then the bytes of all pieces. Little-endian.\n"
    ),
)
PICTURE_SCHEMA: Final = SchemaText(
    name="robocell.Picture",
    encoding="text",
    text=(
        "uint32 little-endian: length of the JSON that follows\n"
        'JSON: {"view": number, "camera": name, "frame": number of the camera\'s frame,\n'
        '  "captured_ns": session clock, "width": px, "height": px, "mime": as sent,\n'
        '  "bytes": length as sent, "sha256": of the bytes as sent,\n'
        '  "encoding": "jpeg" | "png" | "none", "settings": the camera\'s settings}\n'
        "the rest: the picture, encoded as the JSON says\n"
    ),
)
VIEW_SENT_SCHEMA: Final = SchemaText(
    name="robocell.ViewSent",
    encoding="jsonschema",
    text=(
        '{"type": "object", "required": ["view", "camera", "mime", "width", "height", "bytes"],'
        ' "properties": {"view": {"type": "integer", "description": "number of the record in'
        ' views/*; it may follow later"}, "camera": {"type": "string"}, "frame": {"type":'
        ' "integer"}, "mime": {"type": "string"}, "width": {"type": "integer"}, "height":'
        ' {"type": "integer"}, "bytes": {"type": "integer"}}}'
    ),
)
ENDED_SCHEMA: Final = SchemaText(
    name="robocell.SessionEnded",
    encoding="jsonschema",
    text=(
        '{"type": "object", "required": ["reason"], "properties": {"reason": {"type": "string"},'
        ' "lines": {"type": "integer"}, "views": {"type": "integer"},'
        ' "events_lost": {"type": "integer"}}}'
    ),
)
