"""Checks of a solution of a task: its trial, and its worst run."""
