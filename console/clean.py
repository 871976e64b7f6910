"""`cell clean`: every block back to the store, by the ledger."""

from __future__ import annotations

from console.options import AsJson, ProfileName
from console.output import put, put_json
from console.places import cell_folder


def clean(*, script: str = "mash", profile: ProfileName = "mash", as_json: AsJson = False) -> None:
    """Bring every block that lies out back to its slot.

    Works after a crash, too: the ledger knows where the blocks are.

    Args:
        script: The script whose store it is; path, or the name of a shipped one.
        profile: Profile of the cell.
        as_json: Write JSON for programs.
    """
    from cell.assembly import assemble_twin
    from cell.clock import SimulatedClock
    from cell.profile import load_profile
    from console.scripts import load_script
    from sessions.hosting import store_plan

    used = load_profile(profile)
    cell = assemble_twin(
        used,
        store_plan(load_script(script)),
        seed=0,
        clock=SimulatedClock(),
        state_folder=cell_folder(used.name),
    )
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
