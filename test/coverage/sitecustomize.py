"""Measures which lines run in every Python process that script/test starts; see coverage.ini."""
try:
    import coverage
except ImportError:  # another Python
    pass
else:
    coverage.process_startup()
