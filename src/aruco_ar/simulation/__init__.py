"""The simulated robot, the frames of its camera, and the same wall for Gazebo."""
