"""Panels in which something is made with the mouse: colours, robots, calibrations."""
