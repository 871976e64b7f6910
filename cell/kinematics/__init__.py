"""Forward and inverse kinematics of the supported arms. Radians live only here."""
