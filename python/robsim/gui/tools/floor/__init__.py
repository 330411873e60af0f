"""The tool that calibrates where a camera looks at the floor from."""
