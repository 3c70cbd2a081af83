"""Says in a sentence what went wrong in the learner's code, and what helps."""
