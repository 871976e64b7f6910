"""What callers need of an arm, a gripper, a display, a camera and lights.

Protocols and frozen records only. Verbs are idempotent: opening what is open
and closing what is closed is harmless.
"""
