"""Where panels are shown: a notebook, a page on this machine."""
