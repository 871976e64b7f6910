"""From profile to cell: the only place that knows both drivers and twin."""

from cell.assembly.emulated import blocks_in_store
from cell.assembly.hardware import assemble_hardware
from cell.assembly.twin import assemble_twin
from cell.assembly.wires import Wires

__all__ = ["Wires", "assemble_hardware", "assemble_twin", "blocks_in_store"]
