"""How exact the measurement is, beside its bound and beside others: ``./run bench accuracy``."""
