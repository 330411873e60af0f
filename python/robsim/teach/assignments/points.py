"""Points as people read them."""

from __future__ import annotations


def in_hundredths(points: float, most: float) -> float:
    """Return points in hundredths: only all are all, and only none are none."""
    if points >= most:
        return most
    rounded = round(points, 2)
    if rounded >= most:
        rounded = round(rounded - 0.01, 2)
    elif rounded <= 0 < points:
        rounded = 0.01
    return min(max(rounded, 0.0), most)


def fraction_of(points: float, most: float) -> float:
    """Return the share of the points, 0 to 1; all of none is all."""
    return 1.0 if points >= most else max(points / most, 0.0)


def number(points: float) -> str:
    """Return points as a number without zeros at its end."""
    return f"{points:.2f}".rstrip("0").rstrip(".")


def of_most(points: float, most: float) -> str:
    return f"{number(points)} of {number(most)} {'point' if most == 1 else 'points'}"
