"""Pictures of a board from a live camera: one whenever the board stands still somewhere new."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from robsim.base.checks import check_int
from robsim.base.text import listed
from robsim.cli import errors
from robsim.cli.text import about
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.taking import BoardTaker

_PATIENCE = 60.0  # s without a new picture


def taken_pictures(
    camera: str, board: Chessboard | Charuco, count: int, keep: Path | None
) -> list[tuple[str, Any]]:
    """Return names and pictures that a live camera took, and write them to a folder.

    Raises
    ------
    OSError
        If the camera cannot be opened or read, or the board does not come.
    """
    import time

    from robsim.cli.live.sources import _source
    from robsim.lab.cameras.camera import Camera
    from robsim.lab.cameras.errors import EndOfStream
    from robsim.vision.imaging.images import save_image

    with about("--count"):
        check_int("count", count, minimum=4, maximum=200)
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
    taken: list[tuple[str, Any]] = []
    with Camera(_source(camera)) as device:
        taker = BoardTaker(board, device.size)
        errors.print_note(f"hold the board still in front of the camera: {count} times")
        since = time.monotonic()
        while len(taken) < count:
            if time.monotonic() - since > _PATIENCE:
                raise TimeoutError(
                    f"no board stood still somewhere new for {_PATIENCE:g} s: {len(taken)} of "
                    f"{count} pictures were taken"
                )
            try:
                frame = device.read()
            except EndOfStream:
                break
            if not taker.takes(frame.image):
                continue
            since = time.monotonic()
            name = f"{len(taken) + 1:02d}.png"
            taken.append((name, frame.image))
            if keep is not None:
                save_image(keep / name, frame.image)
            parts = taker.empty_parts
            where = f": still nothing at the {listed(parts)}" if parts else ": tilt it another way"
            errors.print_note(f"{len(taken)} of {count}{where if len(taken) < count else ''}")
    return taken
