"""Where the store's sheet lies: touched at its corners, or seen by a calibrated camera."""
