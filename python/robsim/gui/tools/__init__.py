"""Panels for making things with the mouse: colours, robots, calibrations."""
