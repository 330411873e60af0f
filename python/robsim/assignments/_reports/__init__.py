"""Reports of grading: pages, tables and files, for students, teachers and platforms."""
