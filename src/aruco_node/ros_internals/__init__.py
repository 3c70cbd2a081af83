"""Every reach into private parts of ROS.

Each file says which symptom it cures, which versions it was seen with, and when it can go. Where a private part
is no longer what it was, the node warns once and works without the cure, and
test/node/programs/test_ros_internals.py fails.
"""
