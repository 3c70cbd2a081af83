"""Starting, breaking, stopping, skipping and recording: what tests do with processes."""
