"""Runs beside each other: their paths, and what is wrong at each step."""
