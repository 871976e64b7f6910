"""Cleaning by what the camera sees: look, choose grips, push apart, bring home, look again."""
