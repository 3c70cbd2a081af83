#!/usr/bin/env python3
"""A live page in the browser: what all exercises show, side by side, driving, and what is painted."""
from aruco_node.nodes.manual import Manual
from aruco_node.nodes.node import run_node
from page_server.server import Settings, serve

if __name__ == '__main__':
    run_node('page', serve, Manual(
        [('TOPIC', 'sensor_msgs/Image', 'what somebody looks at'),
         ('TOPIC/compressed', 'sensor_msgs/CompressedImage', 'the same as JPEG'),
         ('exercise5_N/tags', 'unit5/TagArray', 'which tags are in sight'),
         ('exercise5_6/parameter_updates', 'dynamic_reconfigure/Config', 'what is painted'),
         ('wall_camera/parameter_updates', 'dynamic_reconfigure/Config', 'what the simulation looks like')],
        [('cmd_vel', 'geometry_msgs/Twist', 'where driving is on'),
         ('~picture', 'sensor_msgs/Image', 'what was dropped onto the page')], [], Settings))
