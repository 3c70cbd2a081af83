"""Hostile values of parameters."""
