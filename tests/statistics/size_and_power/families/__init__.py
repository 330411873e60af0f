"""One module for each family of verdicts, with its campaigns in ``TRIALS``."""
