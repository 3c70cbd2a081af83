"""Tags that are found where there are none, and how far a confidence can be believed."""
