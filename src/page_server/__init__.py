"""The page's server: image topics, driving and the choice of a picture, in a browser.

``server`` starts it. ``handlers`` and ``live`` answer the browser, and ``access`` decides which requests they
answer. ``topics``, ``driving`` and ``choices`` connect it to ROS.
"""
from aruco_ar.base.versions import need

need('tornado')
