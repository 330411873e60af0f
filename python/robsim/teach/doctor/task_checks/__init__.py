"""Checks of what is to solve a task: its trial, and what the worst run shows."""
