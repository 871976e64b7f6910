"""The MAS line protocol without I/O: words, commands, replies, dialects."""
