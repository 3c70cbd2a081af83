"""The calibration of a camera, from views of a flat sheet of tags or of a ChArUco board."""
