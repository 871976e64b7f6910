"""Where the program keeps what it keeps: the platform's data and state folders."""

from __future__ import annotations

from pathlib import Path

import platformdirs

_PROGRAM = "robocell"


def data_folder() -> Path:
    """Return where recordings and pictures go; `XDG_DATA_HOME` moves it."""
    return platformdirs.user_data_path(_PROGRAM)


def recordings_folder() -> Path:
    """Return where recordings go."""
    return data_folder() / "sessions"


def pictures_folder(session_id: str) -> Path:
    """Return where the pictures of a session go."""
    return data_folder() / "pictures" / session_id


def cell_folder(profile_name: str) -> Path:
    """Return where the world and the ledger of a cell are kept; `XDG_STATE_HOME` moves it."""
    return platformdirs.user_state_path(_PROGRAM) / "cells" / profile_name


def calibrations_folder(profile_name: str) -> Path:
    """Return where the calibrations of a cell are kept."""
    return cell_folder(profile_name) / "calibrations"


def calibration_runs_folder(profile_name: str) -> Path:
    """Return where interrupted calibrations of a cell are noted."""
    return cell_folder(profile_name) / "calibration-runs"


def log_folder() -> Path:
    """Return where logs go."""
    return platformdirs.user_state_path(_PROGRAM) / "logs"
