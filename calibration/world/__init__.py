"""Where the lattice lies in the robot frame: fitted, judged, checked."""
