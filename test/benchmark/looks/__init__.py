"""How the painted frame looks, compared with a wall on which the picture is really printed."""
