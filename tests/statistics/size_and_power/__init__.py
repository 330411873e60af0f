"""Size and power of the package's statistical verdicts: how often each is given, and to whom.

``./run study statistics`` prints the table. A module of `families` has the campaigns whose runs
are the trials, in ``TRIALS``. All such modules are found by themselves.
"""

from size_and_power.table import as_json, as_markdown, family_names, measured
from size_and_power.trials import Row, Trials, random_of

__all__ = ["Row", "Trials", "as_json", "as_markdown", "family_names", "measured", "random_of"]
