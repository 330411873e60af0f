"""The teacher's own tests: files for pytest, run in a separate process."""
