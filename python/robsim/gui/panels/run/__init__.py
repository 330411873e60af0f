"""The run: its transport, its controls and its camera view."""
