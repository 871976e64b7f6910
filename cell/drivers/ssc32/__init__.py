"""Lynxmotion SSC-32 and SSC-32U servo controllers: an arm and fingers of hobby servos.

`commands`, `codec` and `tables` turn bytes into records and back without I/O; `servo_map`
goes between angles and pulse widths, `line` between straight moves and short joint moves;
`dialogue` and `panel` talk over a link, `joints` and `sending` move all servos together;
`driver` is the arm, `gripper` the fingers on a sixth servo.
"""
