"""Making an assignment: a template, numbers drawn for it, and a folder of files."""
