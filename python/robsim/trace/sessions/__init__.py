"""Recorded runs: folders of frames, times, inputs and set-up, to be run again and looked at."""
