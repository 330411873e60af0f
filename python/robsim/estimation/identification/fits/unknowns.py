"""The order of the unknowns of a fit."""

X, Y, HEADING = 0, 1, 2
FIRST = 6
"""Number of unknown initial values of a segment: x, y and heading of its first two steps."""
UNKNOWNS = FIRST + 15
