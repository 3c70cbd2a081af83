"""Between messages of ROS and arrays."""
