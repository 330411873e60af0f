"""Foundations that every other room imports: argument checks, files, seeds, shipped data."""
