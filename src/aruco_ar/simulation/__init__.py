"""The simulated robot, what its camera sees, and the same wall for Gazebo."""
