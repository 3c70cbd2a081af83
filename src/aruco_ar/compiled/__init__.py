"""The parts written in C: one library, libunit5, behind one module, ``binding``, which checks all arguments.

The functions are called by ctypes, so that one library serves every version of Python. Numba would take 0.3 s
to import and 110 MB more in each node. Cython's output works with one version of Python only, and is no easier
to read.
"""
