"""The wall that tags hang on: its file, and where on it each tag is."""
