"""The IBM 7545 behind its slave: dual-port registers, and the master's half of the servo.

`registers` holds table 5.1 as data, `pulses` the encoders' scales, `framing` the bytes of
the bridge, `bus` the registers over a link; `trajectory` and `servo` are the master's
motion, `driver` and `gripper` what the cell uses.
"""
