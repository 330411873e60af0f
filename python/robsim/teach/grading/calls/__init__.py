"""Calls of functions and world slots: arrays to a worker, arrays back."""
