"""Mitsubishi MELFA controllers: the R3 text protocol."""
