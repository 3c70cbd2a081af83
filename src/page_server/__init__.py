"""The page's server: image topics, driving and the choice of a picture, in a browser.

``server`` starts it; ``handlers`` and ``live`` answer the browser; ``guard``
says whom; ``topics``, ``driving`` and ``choices`` are what it has to do with ROS.
"""
from aruco_ar.base.versions import need

need('tornado')
