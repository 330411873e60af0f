"""The readers of cameras: a module for each kind."""
