"""One module for each family of verdicts, with a function ``rows(seeds)``."""
