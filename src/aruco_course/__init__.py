"""The course to do: skeletons of the six exercises, and what tells a learner whether his code is right.

``exercises`` has a folder for each exercise: its solution, from which the
skeleton is made, and its check. ``judge`` compares what the learner's code
draws with what is true. ``trial`` runs that code, in a process of its own.
``learner`` has his package and his progress. Nothing here needs ROS.
"""
