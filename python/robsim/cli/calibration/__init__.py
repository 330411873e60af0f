"""Commands of a calibration: sheets to print, lens, floor, check picture."""
