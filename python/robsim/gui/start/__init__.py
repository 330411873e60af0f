"""The start page: what there is to begin with."""
