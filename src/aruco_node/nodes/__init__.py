"""The nodes: what every node does, what those before a camera do, and the exercises."""
