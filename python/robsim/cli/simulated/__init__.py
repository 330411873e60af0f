"""Commands of simulations: templates of callbacks, runs, the demonstration."""
