"""Hostile pictures for everything that finds tags, areas and poses."""
