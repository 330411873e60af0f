"""Files that are dragged into a tab of Chromium, as a file manager does it."""


def drag_file(tab, file, look=None, *, at=(300, 300), drops=True):
    """Drag a file to a place of a tab, and drop it, or leave; `look` is called in between."""
    session = tab.context.new_cdp_session(tab)
    about = {"items": [], "files": [str(file)], "dragOperationsMask": 1}

    def do(kind, x, y):
        session.send("Input.dispatchDragEvent", {"type": kind, "x": x, "y": y, "data": about})

    do("dragEnter", *at)
    do("dragOver", *at)
    if look:
        look()
    if drops:
        do("drop", *at)
    else:
        do("dragOver", -5, -5)
    session.detach()
