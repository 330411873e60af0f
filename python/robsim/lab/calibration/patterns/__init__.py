"""The patterns that are printed for a calibration: drawn, written, found in pictures."""
