"""What is the same in all runs and calls of a submission, and what an assignment may allow."""
