"""What the blocks look like to a camera: colours and sizes learned from the store's own blocks."""
