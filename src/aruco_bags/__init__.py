"""Bags: their frames looked at without a roscore, piece by piece, on as many processor cores as there are."""
