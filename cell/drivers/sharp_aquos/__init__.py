"""SHARP AQUOS television over RS-232: switch it, choose its input, set it up.

`tables` holds the command words, their ranges and the inputs; `codec` turns
records into bytes and back without I/O; `driver` uses both over a link.
"""
