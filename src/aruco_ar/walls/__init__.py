"""The wall that the tags hang on: its file, and the place of each tag on it."""
