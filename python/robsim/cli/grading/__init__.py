"""The commands for teachers, and for students who try what they hand in."""
