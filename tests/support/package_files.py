"""The Python files of the installed package, for tests that read them."""

import os
from pathlib import Path

import robsim

PACKAGE = Path(robsim.__file__).parent


def package_files():
    """Return all of them, those behind links too; that none are found is an error."""
    files = [
        Path(folder, name)
        for folder, _, names in os.walk(PACKAGE, followlinks=True)
        for name in names
        if name.endswith(".py")
    ]
    assert len(files) > 100, f"{len(files)} files in {PACKAGE}"
    return files
