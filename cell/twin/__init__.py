"""The digital twin: a world of blocks, emulators that act on it, cameras that see it.

Stands in for the hardware behind the same wires. It keeps the truth, which only
tests may read.
"""
