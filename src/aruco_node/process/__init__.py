"""The process of a node: its memory, and what it prints."""
