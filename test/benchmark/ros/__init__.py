"""Measurements of nodes, of the page, of the network between them, and of bags."""
