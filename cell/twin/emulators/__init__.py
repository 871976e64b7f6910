"""One emulator a wire protocol: bytes in, bytes out, acting on the twin's world."""
