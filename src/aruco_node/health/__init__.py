"""How a node reports on itself: faults, diagnostics, why no frames arrive, and snapshots."""
