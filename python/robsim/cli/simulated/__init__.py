"""Commands of simulations: callbacks to write, runs with them, the demonstration."""
