"""The area between four tags: in one frame, and over time."""
