"""Deliberate faults in robsim, drawn at random and by name: whether the tests catch them."""
