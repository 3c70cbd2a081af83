"""The nodes: what all of them share, those that work on a camera's frames, and the exercises."""
