"""The chart of the results, and the record of what was printed."""
