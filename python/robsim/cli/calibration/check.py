"""The command ``robsim calibrate check``: the floor's grid, drawn on a picture."""

from __future__ import annotations

from pathlib import Path

from robsim.cli import errors
from robsim.cli.calibration.options import pictures_of


def check(
    picture: Path,
    calibration: Path = Path("camera.toml"),
    step: float | None = None,
    out: Path = Path("check.png"),
) -> None:
    """Draw the floor's grid on a picture, to see whether a calibration fits.

    Yellow lines lie on the floor: tiles and marks at known places must lie on these lines. Blue
    lines are at the height of the robot's markers. If floor sheets still lie as in the calibration,
    the command also reports whether the camera has moved.

    PICTURE: Picture, folder or video; the first picture is used.
    --calibration FILE: The calibration.
    --step MM: Distance between two lines in mm. Default: a round number.
    --out FILE: The picture to write.

    Example: robsim calibrate check floor.png --calibration camera.toml --out check.png
    """
    from robsim.lab.calibration.grid import draw_grid, remedy_of_shifts, sheet_shifts
    from robsim.vision.imaging.calibration_file import load_calibration
    from robsim.vision.imaging.images import save_image

    if out.resolve() == picture.resolve():
        raise ValueError(f"--out {out} would overwrite the picture: give another name")
    loaded = load_calibration(calibration)
    image = next(pictures_of([picture]))[1]
    save_image(out, draw_grid(image, loaded, step=step))
    shifts = {}
    try:
        shifts = sheet_shifts(image, loaded)
    except ImportError as error:
        errors.print_note(f"floor sheets were not searched: {error}")
    for sheet, shift in shifts.items():
        errors.say(f"floor sheet {sheet}: {shift:.1f} px from its place in the calibration")
    if remedy := remedy_of_shifts(shifts):
        errors.print_note(remedy)
    if loaded.marks and not shifts:
        errors.say("the picture shows no floor sheet of the calibration")
    errors.say(f"written: {out}")
