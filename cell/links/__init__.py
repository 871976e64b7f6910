"""How bytes travel to and from a device: in memory, captured, replayed."""
