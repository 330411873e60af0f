"""Grading a submission: its runs and those of the reference, points, sentences, pictures."""
