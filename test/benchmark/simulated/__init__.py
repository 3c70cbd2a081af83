"""Measurements on simulated frames, about which the truth is known."""
