"""The command aruco-ar: what the nodes do, on a desk without ROS.

``command`` reads the command line. ``footage`` reads videos, photos and cameras,
and ``paint`` runs exercise 5.6 on them.
"""
