"""What the check of a running node needs, besides ROS: its process, which frame it shows, and what to say.

A node is any executable, in any language. It is judged by what it publishes alone.
"""
