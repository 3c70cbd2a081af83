"""Settings: what a user can choose, each with a default, a description, and the values that it takes."""
