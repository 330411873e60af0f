"""The hosts of panels: a notebook, or a page on this machine."""
