"""The checks of a parameter estimator, each of one property of it."""
