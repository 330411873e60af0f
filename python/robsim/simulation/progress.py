"""Progress bars for people: none in a log, which is no terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

from robsim.base.text import one_line


def progress_bar(items: Iterable[Any] | None = None, **options: Any) -> Any:
    """Return a bar of tqdm on a terminal or in a notebook, and one that stays silent elsewhere.

    Parameters
    ----------
    items : iterable, optional
        What the bar counts while it is iterated over.
    **options
        Those of ``tqdm.tqdm``.
    """
    from tqdm.auto import tqdm

    if "desc" in options:
        options["desc"] = one_line(options["desc"])

    is_notebook = any(base.__module__ == "tqdm.notebook" for base in tqdm.__mro__)
    return tqdm(items, disable=not (is_notebook or sys.stderr.isatty()), **options)
