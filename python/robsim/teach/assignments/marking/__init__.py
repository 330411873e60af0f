"""Grading a submission: its runs and the reference's, points, sentences, pictures."""
