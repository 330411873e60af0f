"""The controls that work during a run."""
