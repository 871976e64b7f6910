"""One package a device model: codec (no I/O), tables, driver."""
