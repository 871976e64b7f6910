"""MCAP records as bytes: the library's own for all but messages, which are hot.

A session appends a dozen small messages a step. Packing them here costs a tenth
of the library's writer; the layout is that of the specification (record = opcode
uint8, length uint64; message = channel uint16, sequence uint32, log time uint64,
publish time uint64, data; little-endian), and tests read the result with the
library's readers.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    DataEnd,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

MAGIC = MCAP0_MAGIC
RECORD_HEAD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<BQHIQQ")
MESSAGE_FIELDS_SIZE = MESSAGE_HEAD.size - RECORD_HEAD.size
_FOOTER_FIELDS_SIZE = 8 + 8 + 4


def pack(record: McapRecord) -> bytes:
    """Return a record as bytes."""
    builder = RecordBuilder()
    record.write(builder)
    packed: bytes = builder.end()  # type: ignore[no-untyped-call]
    return packed


@dataclass(slots=True, kw_only=True)
class Index:
    """What the summary at the file's end is made of."""

    schemas: list[Schema] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    message_counts: dict[int, int] = field(default_factory=dict)
    start_ns: int = 0
    end_ns: int = 0


def pack_end(index: Index, data_end_offset: int) -> bytes:
    """Return everything that closes a file: data end, summary, footer, magic.

    Args:
        index: What the file holds.
        data_end_offset: Offset in the file at which the result will be written.
    """
    data_end = pack(DataEnd(data_section_crc=0))
    summary_start = data_end_offset + len(data_end)
    groups: list[tuple[int, list[McapRecord]]] = [
        (Opcode.SCHEMA, list(index.schemas)),
        (Opcode.CHANNEL, list(index.channels)),
        (Opcode.STATISTICS, [_statistics(index)]),
        (Opcode.ATTACHMENT_INDEX, list(index.attachments)),
        (Opcode.METADATA_INDEX, list(index.metadata)),
    ]
    summary = b""
    offsets = b""
    for opcode, records in groups:
        group = b"".join(pack(record) for record in records)
        offsets += pack(
            SummaryOffset(
                group_opcode=opcode,
                group_start=summary_start + len(summary),
                group_length=len(group),
            )
        )
        summary += group
    offset_start = summary_start + len(summary)
    summary += offsets
    # The checksum covers the footer up to itself (specification, "Footer").
    checked = summary + struct.pack(
        "<BQQQ", Opcode.FOOTER, _FOOTER_FIELDS_SIZE, summary_start, offset_start
    )
    footer = Footer(
        summary_start=summary_start,
        summary_offset_start=offset_start,
        summary_crc=zlib.crc32(checked),
    )
    return data_end + summary + pack(footer) + MAGIC


def _statistics(index: Index) -> Statistics:
    return Statistics(
        attachment_count=len(index.attachments),
        channel_count=len(index.channels),
        channel_message_counts={c: n for c, n in index.message_counts.items() if n},
        chunk_count=0,
        message_count=sum(index.message_counts.values()),
        message_end_time=index.end_ns,
        message_start_time=index.start_ns,
        metadata_count=len(index.metadata),
        schema_count=len(index.schemas),
    )
