"""Counting instructions, which shows a change of cost that a busy machine would hide."""
