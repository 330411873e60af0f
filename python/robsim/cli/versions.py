"""Facts about an installation that a bug report needs."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires, version


def facts() -> Iterator[str]:
    """Yield the system, the versions of packages, the processor, the cameras and the isolation."""
    import numpy as np

    from robsim._core import cpu_path
    from robsim.lab.cameras.finding import find_cameras

    implementation = platform.python_implementation()
    yield f"{implementation} {platform.python_version()} on {platform.platform()}"
    blas = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
    yield f"vector instructions: {cpu_path()}"
    yield f"BLAS of numpy: {blas['name']} {blas['version']}"
    yield f"packages: {', '.join(_packages())}"
    cameras = find_cameras()
    yield from (f"camera: {sentence}" for sentence in cameras.found)
    yield from (f"no camera: {sentence}" for sentence in cameras.missing)
    yield f"isolation of submissions: {_isolation()}"


def _packages() -> Iterator[str]:
    names = [re.split(r"[^\w.-]", one)[0] for one in requires("robsim") or ()]
    for name in sorted({*names} - {"robsim"}):
        try:
            yield f"{name} {version(name)}"
        except PackageNotFoundError:  # of an extra
            continue


def _isolation() -> str:
    from robsim.teach.errors import GraderError
    from robsim.teach.isolation.check import check_isolation

    try:
        return check_isolation().verdict
    except GraderError as error:
        return f"unknown: {error}"
