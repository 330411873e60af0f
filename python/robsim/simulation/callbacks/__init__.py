"""Callbacks of the user: their checks when they are set, and their errors when they fail."""
