"""The start and the end of workers' processes, and the removal of their remains."""
