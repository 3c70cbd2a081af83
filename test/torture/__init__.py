"""The torture tests: what the package withstands."""
