"""Cameras through OpenCV: FireWire (IIDC), Linux video devices, files, folders, streams."""
