"""Grading: runs of submissions and of the reference, points, files that are gone on with."""
