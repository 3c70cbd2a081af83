"""What a node says about itself: faults, diagnostics, why no frames arrive, snapshots."""
