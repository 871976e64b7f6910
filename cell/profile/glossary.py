"""What fields are for whose name means the same wherever it is used.

A docstring below the field itself goes before these words.
"""

from __future__ import annotations

from typing import Final

GLOSSARY: Final = {
    "model": "Which one it is; it decides which further fields there are.",
    "serial": "The port it is wired to.",
    "joint_min_deg": "Least angles of the joints, J1 first.",
    "joint_max_deg": "Greatest angles of the joints, J1 first.",
    "joint_speed_deg_s": "Greatest speeds of the joints, J1 first.",
    "joint_min": "Least positions of the joints, J1 first: deg, or mm where one slides.",
    "joint_max": "Greatest positions of the joints, J1 first: deg, or mm where one slides.",
    "link_mm": "Lengths of the links, from joint to joint.",
    "linear_speed_mm_s": "Speed of the tool point along lines, unless another is set.",
    "max_linear_speed_mm_s": "Greatest speed of the tool point that may be set.",
    "joint_speed_percent": "Share of the joints' full speed in joint moves, unless another is set.",
    "servo": "How the motor or servo is driven.",
    "servos": "The servos, J1 first.",
    "lengths": "Lengths of the arm's members, from joint to joint.",
    "fingers": "The fingers and the servo that moves them.",
    "upper_arm_mm": "From the shoulder to the elbow.",
    "forearm_mm": "From the elbow to the wrist.",
    "channel": "Channel of the servo controller that the servo is plugged into.",
    "min_us": "Shortest pulse that the servo may be given.",
    "max_us": "Longest pulse that the servo may be given.",
    "min_mm": "Least value that is allowed, or the corner with the least x, y and z.",
    "max_mm": "Greatest value that is allowed, or the corner with the greatest x, y and z.",
    "speed_mm_s": "How fast it moves.",
    "period_us": "Time from one cycle of the position control to the next.",
    "kp": "Gain of the position control for each joint, J1 first.",
    "kv": "Gain of the speed control for each joint, J1 first.",
    "announce_s": "How long before it moves by itself people are told.",
    "timeout_s": "How long an answer may take.",
    "brightness_percent": "Black level of the picture.",
    "exposure_ev": "Exposure that automatic shutter and gain aim at.",
    "sharpness": "How much edges are raised; 1024 leaves them as they are.",
    "hue_deg": "By how much colours are turned.",
    "saturation_percent": "How strong colours are; 100 leaves them as they are.",
    "gamma": "Exponent of the brightness curve; 1 is a straight line.",
    "pan": "The camera's feature PAN, as the cell's cameras are set.",
    "tilt": "The camera's feature TILT, as the cell's cameras are set.",
    "shutter_ms": "How long the sensor gathers light.",
    "gain_db": "By how much the sensor's signal is amplified.",
    "white_balance_red": "Raw gain of red against green.",
    "white_balance_blue": "Raw gain of blue against green.",
}
