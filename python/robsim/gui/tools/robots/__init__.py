"""The panel that defines a robot."""
