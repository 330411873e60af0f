"""Grading classes: their submissions, schedule, kept results, and files."""
