"""How fast the panel is, what is painted and when: ``./run bench panel``."""
