"""Lenses from pictures of a board: fitted, judged, checked."""
