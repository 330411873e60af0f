"""Callbacks from a folder of files."""
