"""The layers of a worker's sandbox, one per module; each returns a report."""
