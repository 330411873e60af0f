"""The panel that trains colours."""
