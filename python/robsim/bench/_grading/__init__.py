"""What a step of a graded run costs: the robot half in a worker, beside all in one process."""
