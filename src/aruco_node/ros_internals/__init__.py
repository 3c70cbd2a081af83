"""Every reach into private parts of ROS. Each file says the symptom, and when it can go."""
