"""The node page: what the page shows and changes in ROS. ``page_server`` serves it."""
