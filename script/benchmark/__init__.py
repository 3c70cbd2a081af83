"""The benchmark: the code of the course and that of this package, measured on the same frames."""
import os

PACKAGE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
