"""Assignments: what students hand in, graded by tasks and tests, with reports."""
