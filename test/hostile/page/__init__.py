"""Hostile clients of the page's server."""
