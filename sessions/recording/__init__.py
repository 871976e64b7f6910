"""Recordings of sessions: the MCAP file, its writer and its reader."""
