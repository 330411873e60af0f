"""The commands ``robsim tasks``."""
