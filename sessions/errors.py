"""The base of every error raised by `sessions`."""

from __future__ import annotations


class SessionError(Exception):
    """Base of every error raised by `sessions`; its text is fit for a user."""
