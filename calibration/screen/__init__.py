"""The screen under the playground as a calibration target: lenses, places, screen to robot."""
