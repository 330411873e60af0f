"""The checks of a state estimator, each of one property of it."""
