"""Recorded runs: files of frames, times, inputs and set-up, for reruns and playback."""
