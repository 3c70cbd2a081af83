"""A base station and robots as hosts of a network, with poor links between them."""
