"""What tests share: nodes before a camera, processes, robots far away, the page, drives with tags."""
