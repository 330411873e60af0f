"""Figures of numbers: of a run, of its reports, of colours."""
