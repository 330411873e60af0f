"""Size and power of the package's statistical verdicts: how often each is given, and to whom.

``./run statistics`` prints the table. A module of `families` has a function ``rows(seeds)`` that
returns a list of `Row`, the same ones for all seeds, and may say in ``SHARE`` which share of the
seeds it takes, because a trial of it is slow. All such modules are found by themselves.
"""

from size_and_power.row import Row, counted
from size_and_power.table import as_json, as_markdown, family_names, measured

__all__ = ["Row", "as_json", "as_markdown", "counted", "family_names", "measured"]
