"""Marks for other programs: tables for learning platforms, Gradescope."""
