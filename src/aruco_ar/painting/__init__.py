"""The picture, and painting marks, masks and pictures on frames."""
