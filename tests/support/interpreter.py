"""Keeping the interpreter, as a callback does that calls C and does not give it back."""

import ctypes

#: s, one after the other: on a busy machine it may take long until other threads have their turn.
LONGER_AND_LONGER = (0.2, 1, 4, 16)


def keep_interpreter(seconds):
    ctypes.PyDLL(None).usleep(int(1e6 * seconds))
