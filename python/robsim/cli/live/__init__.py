"""Commands of live cameras: which there are, whether one is good, a run with it."""
