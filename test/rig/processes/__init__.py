"""Starting, breaking, stopping and skipping: what tests do with processes."""
