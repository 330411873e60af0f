"""The tool that calibrates a camera's view of the floor."""
