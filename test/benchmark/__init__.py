"""The benchmark: the code of the course and that of this package, measured on the same frames."""
