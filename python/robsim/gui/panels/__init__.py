"""The parts of the main panel."""
