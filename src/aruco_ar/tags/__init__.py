"""Tags: the Tag and its dictionaries, finding tags in a frame, and printing them."""
