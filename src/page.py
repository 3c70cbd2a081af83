#!/usr/bin/env python3
"""A live page in the browser: what all exercises show, side by side, driving, and what is painted."""
from aruco_node.node import run_node

from page_server.server import serve

if __name__ == '__main__':
    run_node('page', serve)
