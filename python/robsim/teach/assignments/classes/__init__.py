"""Grading classes: which submissions, in which order, what is kept, and the files of a class."""
