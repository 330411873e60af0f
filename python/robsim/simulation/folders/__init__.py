"""Callbacks in a folder with a file per slot, for `Simulation.from_folder` and `robsim new`."""
