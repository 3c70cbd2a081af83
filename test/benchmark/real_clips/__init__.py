"""Both methods on videos of real cameras, compared with the truth about them."""
