"""The checks of all callbacks other than estimators, and of a whole folder."""
