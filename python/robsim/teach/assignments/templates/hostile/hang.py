"""Answers at first, and then never again, despite all exceptions."""

calls = 0


def SLOT(*given):
    global calls
    calls += 1
    if calls < 3:
        return NOTHING
    while True:
        try:
            while True:
                pass
        except BaseException:
            continue
