"""The camera on the link of the avrs cell: where it sits, found in two stages."""
