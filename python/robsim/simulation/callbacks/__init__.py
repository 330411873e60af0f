"""Callbacks of the user: what is told of them when they are set, and when they fail."""
