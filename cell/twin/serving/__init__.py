"""Emulators behind real ports: a pseudo-terminal or a TCP socket, for our drivers or anybody's."""
