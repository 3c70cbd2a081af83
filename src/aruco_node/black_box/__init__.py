"""Checks a running node by what it publishes: see aruco_course.black_box, which has all that needs no ROS."""
