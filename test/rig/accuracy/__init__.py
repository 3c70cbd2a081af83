"""How far off areas and poses are on simulated drives."""
