"""Devices, motion, vision and the digital twin of a small robot cell.

The lowest of the five packages: it knows nothing of tasks, sessions or how a
calibration is made.
"""
