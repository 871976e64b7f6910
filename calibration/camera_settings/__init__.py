"""Shutter, gain and white balance of a camera: searched, typed or taken from a table."""
