"""Our detector and those of others, on the same frames."""
