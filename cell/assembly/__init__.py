"""From profile to cell: the only place that knows both drivers and twin."""

from cell.assembly.twin import assemble_twin, blocks_in_store

__all__ = ["assemble_twin", "blocks_in_store"]
