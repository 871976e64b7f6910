"""From pictures of the top camera to the robot frame: fitted, judged, checked."""
