"""Callbacks of a notebook: chosen by tag or by name, without running its other cells."""
