"""Marks for other programs: tables for learning platforms, JUnit, Gradescope."""
