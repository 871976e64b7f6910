"""`cell clean`: every block back to the store, by the ledger."""

from __future__ import annotations

from console.options import AsJson, ProfileName, WiresOption
from console.output import put, put_json


def clean(
    *,
    script: str = "mash",
    profile: ProfileName = "mash",
    wires: WiresOption = "memory",
    as_json: AsJson = False,
) -> None:
    """Bring every block that lies out back to its slot.

    Works after a crash, too: the ledger knows where the blocks are.

    Args:
        script: The script whose store it is; path, or the name of a shipped one.
        profile: Profile of the cell.
        wires: How devices are reached.
        as_json: Write JSON for programs.
    """
    from cell.profile import load_profile
    from console.assembling import assemble, clock_for

    cell = assemble(load_profile(profile), script, wires, clock_for(wires))
    try:
        cell.open()
        slots = cell.clean()
        cell.close()
    finally:
        cell.dispose()
    if as_json:
        put_json({"brought_home": slots})
    elif slots:
        put(f"brought home: {', '.join(f'slot {slot}' for slot in slots)}")
    else:
        put("the table was clean already")
