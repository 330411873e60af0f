"""The start page: cards that open a first run."""
