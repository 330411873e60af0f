"""Checking an assignment before it is used: by grading all that is known to be right or wrong."""
