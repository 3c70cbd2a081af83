"""Sentences for a user whose tags are other than the parameters say, or who may be surprised by the area."""
