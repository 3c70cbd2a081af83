"""The process of a node: its memory, and its output streams."""
