"""Other systems than the one that runs the tests: what they lack, and what they load."""
