"""Tests of the teacher's own: files for pytest, run in a process of their own."""
