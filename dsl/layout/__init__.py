"""Where the blocks of a task lie: which blocks, on which points, or why nowhere."""
