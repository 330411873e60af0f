"""Engines for the runs of a campaign: here, in threads, in processes, in any executor."""
