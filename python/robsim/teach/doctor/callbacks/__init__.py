"""The checks of the callbacks that are no estimators, and of a whole folder."""
