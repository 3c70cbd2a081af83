"""Tags: what one is, finding them in a frame, and printing them."""
