"""The printed patterns of a calibration: drawing, saving and finding them in pictures."""
