"""Grading: submissions that run in a process of their own, and whose fault it is if they fail."""

__all__: list[str] = []
