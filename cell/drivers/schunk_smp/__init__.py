"""SCHUNK PG-70 gripper: the SCHUNK Motion Protocol over a serial line."""
