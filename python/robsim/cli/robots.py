"""The commands ``robsim robots``: list, show, add, rotate, choose and remove robots."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from robsim.base.text import one_line, quoted
from robsim.cli import errors
from robsim.cli.command import command, command_group
from robsim.cli.text import parse_point, parse_points

if TYPE_CHECKING:
    from robsim.vision.robots.definition import RobotDefinition

HELP = (
    "A robot is an image from above with an outline, two markers of different colours, a size and "
    "an alignment. Some robots ship with robsim; your own are stored in your user folder, or in "
    "$ROBSIM_DATA."
)
app = command_group("Start with: robsim robots list")

Name = Annotated[str, "NAME: Name of the robot."]
Colors = Annotated[Path | None, "--colors FILE: Colour file. [default: that of robsim]"]

_FACES = {0.0: "right", 90.0: "up", 180.0: "left", 270.0: "down"}


@command(app, "list")
def list_robots() -> None:
    """List all robots, and mark the default.

    Example: robsim robots list
    """
    from rich.box import SIMPLE_HEAD
    from rich.markup import escape
    from rich.table import Table

    from robsim.vision.robots.lookup import default_robot, load_robot, stored_robots

    problems: list[object] = []
    default = None
    try:
        default = default_robot()
    except ValueError as error:
        problems.append(error)
    stored = stored_robots(default)
    if default is not None and not any(one.is_default for one in stored):
        try:
            load_robot()
        except ValueError as error:
            problems.append(error)
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("robot", overflow="fold", max_width=16)
    for title in ("size", "alignment", "markers apart", "whose", ""):
        table.add_column(title, no_wrap=True)
    for one in stored:
        whose, use = "shipped" if one.is_shipped else "yours", "in use" if one.is_default else ""
        numbers = _numbers_of(one.folder, problems)
        table.add_row(escape(one_line(one.name)), *numbers, whose, use)
        if not one.is_found:
            problems.append(
                f"{one_line(one.folder)}: another robot of this name takes precedence; rename the "
                "folder"
            )
    errors.print_table(table)
    for sentence in problems:
        errors.print_error(sentence)


@command(app)
def show(name: str | None = None, out: Path | None = None, colors: Colors = None) -> None:
    """Draw a robot with its outline, markers and heading, and check it.

    NAME|FOLDER: Name of a robot, or its folder. [default: the default robot]
    --out FILE: File for the drawing. [default: robot-NAME.png]

    Example: robsim robots show lab
    """
    from robsim.cli.results import save_figure
    from robsim.plotting import plot_robot
    from robsim.vision.robots.lookup import load_robot
    from robsim.vision.robots.marker_check import check_colors

    robot = load_robot(name)
    problems = check_colors(robot, colors).sentences
    plain_name = re.sub(r"[^\w-]+", "-", robot.name)
    file = out or Path(f"robot-{plain_name}.png")
    file = file if file.suffix else file.with_suffix(".png")
    save_figure(file, plot_robot(robot).get_figure())
    errors.show(_described(robot))
    errors.say(f"figure written to {file}")
    for problem in problems:
        errors.print_error(problem)


@command(app)
def add(
    name: Name,
    source: str,
    size: float | None = None,
    alignment: float | None = None,
    centre: str | None = None,
    outline: str | None = None,
    markers: list[str] | None = None,
    colors: Colors = None,
    marker_colors: str | None = None,
    overwrite: bool = False,
    ignore_colors: bool = False,
) -> None:
    """Add a robot to your user folder.

    Missing options are derived from an image, or copied from another robot. The robot's
    surroundings in the image must be transparent, unless you give --outline. The roles of the
    markers, right and left, or front and back, follow from their positions. Check the result with
    [bold]robsim robots show[/], and rotate the robot with [bold]robsim robots rotate[/].

    SOURCE: An image (PNG), the name of a robot, or a folder with a robot.
    --size PX: Width of the image on the work area in px. [default: 120]
    --alignment DEGREES: Clockwise rotation in degrees that makes the robot face right. [default: 0]
    --centre X,Y: Centre in the image in px, such as 240,250 (right, down). [default: the centre of
        the outline]
    --outline POINTS: Polygon in the image, such as '120,40 180,40 180,90'. [default: around the
        opaque pixels]
    --marker NAME=POINTS: Polygon of the marker with this colour, such as
        'red=120,40 180,40 180,90'. Can be repeated. [default: the largest blob of each colour]
    --marker-colors NAME,NAME: Names of the two markers' colours in the colour file. To replace the
        colours of another robot, use the order of the markers' roles. [default: red,blue]
    --overwrite: Replace your robot with this name.
    --anyway: Add the robot even if its markers are not detected.

    Example: robsim robots add mine photo.png --size 120
    """
    from robsim.vision.robots.user_robots import add_robot

    robot = add_robot(
        name,
        source,
        size=size,
        alignment=alignment,
        centre=parse_point("--centre", centre),
        outline=parse_points("--outline", outline),
        markers=_parsed_markers(markers) if markers else None,
        colors=colors,
        marker_colors=marker_colors.split(",") if marker_colors else None,
        overwrite=overwrite,
        ignore_colors=ignore_colors,
    )
    errors.show(_described(robot))
    errors.say(f"added: check it with `robsim robots show {name}`, then `robsim robots use {name}`")


def _parsed_markers(texts: list[str]) -> dict[str, list[tuple[float, float]]]:
    """Return the polygons of markers by colour from texts such as red=120,40 180,40 180,90."""
    markers = {}
    for text in texts:
        color, equals, points = text.partition("=")
        if not equals or not color or color in markers:
            raise ValueError(
                "--marker must name each colour once, such as 'red=120,40 180,40 180,90', got "
                f"{quoted(text)}"
            )
        markers[color] = parse_points("--marker", points, prefix=f"{color}=") or []
    return markers


# A negative number is not an option here.
@command(app, context_settings={"ignore_unknown_options": True})
def rotate(name: Name, degrees: float) -> None:
    """Rotate the image of one of your robots, so that the robot faces right.

    DEGREES: Angle in degrees, clockwise; a negative angle is anticlockwise.

    Example: robsim robots rotate mine -90
    """
    from robsim.vision.robots.user_robots import rotate_robot

    robot = rotate_robot(name, degrees)
    errors.show(_described(robot))


@command(app)
def use(name: Name) -> None:
    """Choose the default robot; the choice is stored.

    Example: robsim robots use lab
    """
    from robsim.vision.robots.lookup import default_robot, set_default_robot

    set_default_robot(name)
    errors.say(f"in use: {default_robot()}")


@command(app)
def reset() -> None:
    """Make "lab" the default robot again.

    Example: robsim robots reset
    """
    from robsim.vision.robots.lookup import default_robot, reset_default_robot

    reset_default_robot()
    errors.say(f"in use: {default_robot()}")


@command(app)
def remove(name: Name) -> None:
    """Remove one of your robots.

    Example: robsim robots remove mine
    """
    from robsim.vision.robots.lookup import default_robot
    from robsim.vision.robots.user_robots import remove_robot

    remove_robot(name)
    errors.say(f"{name} is removed; in use: {default_robot()}")


def _numbers_of(folder: Path, problems: list[object]) -> tuple[str, str, str]:
    """Return size, alignment and marker distance; an error is appended to `problems`."""
    from robsim.vision.robots.lookup import load_robot

    try:
        robot = load_robot(folder)
    except ValueError as error:
        problems.append(error)
        return "damaged", "", ""
    return f"{robot.size:g} px", _alignment(robot), f"{robot.marker_layout().distance:.1f} px"


def _alignment(robot: RobotDefinition) -> str:
    facing = _FACES.get(robot.alignment % 360)
    return f"{robot.alignment:g}°" + (f", faces {facing}" if facing else "")


def _described(robot: RobotDefinition) -> str:
    height, width = robot.image.shape[:2]
    markers = robot.marker_layout()
    assert robot.centre is not None
    right, down = robot.centre
    side = "behind" if markers.offset >= 0 else "ahead of"
    offset = f"{abs(markers.offset):.1f} px {side} the centre"
    if abs(markers.offset) < 0.05:
        offset = "their midpoint level with the centre"
    return (
        f"{robot.name}: image of {width} x {height} px, {robot.size:g} px wide on the work area\n"
        f"  alignment  {_alignment(robot)}\n"
        f"  centre     at ({right:.1f}, {down:.1f}) of the image\n"
        f"  outline    up to {robot.radius:.1f} px from the centre\n"
        f"  markers    {markers.distance:.1f} px apart, {offset}\n"
        + "\n".join(
            f"  {role:<10} {color}, {markers.areas[role]:.0f} px of the work area"
            for role, color in markers.colors.items()
        )
    )
