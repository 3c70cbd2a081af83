"""Hostile messages, pictures, bytes, parameters and HTTP clients."""
