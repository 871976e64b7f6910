"""The servos of the lynx cell: where each goes when it is told to, and how the arm sags."""
