"""`cell profile`: what the program knows of a cell."""

from __future__ import annotations

from cyclopts import App

from console.options import AsJson
from console.output import put, put_json

app = App(name="profile")


@app.command
def show(name: str = "mash", /, *, as_json: AsJson = False) -> None:
    """Show a profile, checked, with every default filled in.

    Args:
        name: Name of a shipped profile, or the path of one.
        as_json: Write JSON for programs.
    """
    from cell.profile import parse_profile, profile_text

    text = profile_text(name)
    profile = parse_profile(text, name)
    if as_json:
        put_json(profile.model_dump(mode="json"))
    else:
        put(text.rstrip())


@app.command(name="list")
def list_profiles(*, as_json: AsJson = False) -> None:
    """List the shipped profiles."""
    from cell.profile import shipped_profiles

    names = shipped_profiles()
    if as_json:
        put_json(names)
    else:
        put("\n".join(names))
