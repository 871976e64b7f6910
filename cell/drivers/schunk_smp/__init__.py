"""SCHUNK Motion Protocol over RS-232: the PG-70 gripper and its relatives.

`crc`, `framing`, `commands`, `replies` and their two codecs turn bytes into records
and back without I/O; `tables` holds the protocol's numbers and their meaning;
`conversation` and `driver` use them over a link.
"""
