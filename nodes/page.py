#!/usr/bin/env python3
"""A live page in the browser: the images of all exercises, driving, and the choice of the picture."""
from aruco_node.nodes.manual import Manual
from aruco_node.nodes.node import run_node
from aruco_node.page.node import PageSettings, serve

if __name__ == '__main__':
    run_node('page', serve, Manual(
        [('TOPIC', 'sensor_msgs/Image', 'the image topics that a browser shows'),
         ('TOPIC/compressed', 'sensor_msgs/CompressedImage', 'the same as JPEG'),
         ('exercise5_N/tags', 'unit5/TagArray', 'the ids of the tags in sight'),
         ('exercise5_N/parameter_updates', 'dynamic_reconfigure/Config',
          'the tags that count, and the picture that is painted'),
         ('wall_camera/parameter_updates', 'dynamic_reconfigure/Config', 'the settings of the simulation'),
         ('/diagnostics', 'diagnostic_msgs/DiagnosticArray', 'what the nodes say of themselves')],
        [('cmd_vel', 'geometry_msgs/Twist', 'commands to the robot, if driving is on'),
         ('~picture', 'sensor_msgs/Image', 'the picture that was dropped onto the page')], [], PageSettings))
