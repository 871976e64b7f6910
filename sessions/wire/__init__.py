"""The MAS line protocol without I/O: words, lines, commands, replies, dialects.

Knows no sockets and no cell. A server feeds a `LineReader` and turns lines into
commands with `parse_command`; a client writes commands with `format_command`
and reads replies with an `AnswerReader`.
"""
