"""Packing an assignment: for students, for Gradescope."""
