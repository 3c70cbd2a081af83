"""High load, long runs, full disks and signals at random moments."""
