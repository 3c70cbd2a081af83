"""Runs the learner's code in a process of its own, and says in a sentence what went wrong.

``trial`` runs a function or a program; ``process`` has the process, and ``inside`` what runs in it.
``source`` and ``plumbing`` read the file without running it. ``sentences`` has what is said.
"""
from .limits import Limits
from .plumbing import fault_of_plumbing
from .source import fault_of_source, is_node_only
from .speed import fault_of_speed
from .trial import Trial, run_function, run_program

__all__ = ['Limits', 'Trial', 'fault_of_plumbing', 'fault_of_source', 'fault_of_speed', 'is_node_only',
           'run_function', 'run_program']
