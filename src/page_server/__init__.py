"""The page's server: live images, driving and the choice of a picture, in a browser. It needs no ROS.

``server`` starts it. ``handlers`` and ``live`` answer the browser, and ``access`` decides which requests they
answer. ``choices`` and ``shelf`` are what can be chosen. Who serves the page makes a Site of its own: the node
page has one of ROS topics (aruco_node.page), and aruco-ar one of a camera (aruco_desk.page).
"""
from aruco_ar.base.versions import need

need('tornado')
