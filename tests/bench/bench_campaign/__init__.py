"""What campaigns cost, beside the same loops by hand: ``./run bench campaign``."""
