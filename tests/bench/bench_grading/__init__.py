"""What a step of a graded run costs, beside all in one process: ``./run bench grading``."""
