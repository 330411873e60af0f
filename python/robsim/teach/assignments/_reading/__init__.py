"""Reading an assignment: its file, its limits, its solutions, what students are given."""
