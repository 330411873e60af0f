"""Pages in HTML, for students and teachers."""
