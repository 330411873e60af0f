"""Draw the rest of the tasks of gymnasium as fields over the floor: ./run pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from draw_readme import picture
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

import robsim
from robsim.plotting import style as style
from robsim.teach.gym.environment import REWARDS
from robsim.teach.tasks.definition import Task

FIGURE = Path(__file__).parents[1] / "notebooks/site/environments.png"
START = (500.0, 500.0, 0.0)  # where the path to follow begins
_SPACING = 10  # px between two points of a field


def field(task: Task, heading: float, passed: int) -> tuple[NDArray[np.float64], ...]:
    """Return x, y (px) and the rest there, for a heading (rad) and some waypoints passed."""
    width, height = task.scenario.area
    x, y = np.meshgrid(np.arange(0, width + 1, _SPACING), np.arange(0, height + 1, _SPACING))

    def left_at(x: float, y: float) -> float:
        left = REWARDS[type(task)](task, np.array(START))
        for waypoint in getattr(task, "waypoints", ())[:passed]:
            left(np.array((*waypoint, heading)))
        return left(np.array((x, y, heading)))

    return x, y, np.vectorize(left_at)(x, y)


@style.applied
def figure() -> Figure:
    """A row for each environment: parking by heading error, following by waypoints passed."""
    park, follow = robsim.teach.ParkTask(noise=0), robsim.teach.FollowTask(noise=0)
    drawn = style.NotebookFigure(figsize=(11, 7), layout="constrained")
    panels = drawn.subplots(2, 3, sharex=True, sharey=True)
    for panel, degrees in zip(panels[0], (0, 90, 180), strict=True):
        _draw(panel, park, park.goal[2] + np.deg2rad(degrees), 0)
        panel.plot(*park.goal[:2], "w*", markersize=12, markeredgecolor="k")
        panel.set_title(f"park, heading error {degrees} degrees")
    for passed, panel in enumerate(panels[1]):
        _draw(panel, follow, 0.0, passed)
        panel.plot(*np.transpose([START[:2], *follow.waypoints]), "w-o", markeredgecolor="k")
        panel.set_title(f"follow, on the way to waypoint {passed + 1}")
    drawn.supxlabel("x (px)")
    drawn.supylabel("y (px)")
    return drawn


def _draw(panel: Axes, task: Task, heading: float, passed: int) -> None:
    x, y, left = field(task, heading, passed)
    panel.imshow(task.simulation(seed=1).frame.image, extent=(0, x.max(), y.max(), 0), alpha=0.4)
    levels = np.arange(0, left.max() + 0.25, 0.25)
    panel.contourf(x, y, left, levels, cmap="viridis_r", alpha=0.5)
    lines = panel.contour(x, y, left, levels[::2], colors="k", linewidths=0.6)
    panel.clabel(lines, fmt="%g", fontsize=8)
    panel.set_aspect("equal")


def main() -> None:
    """Write the figure of the page."""
    image = picture(figure())
    image.quantize(128, dither=Image.Dither.NONE).save(FIGURE, optimize=True)


if __name__ == "__main__":
    main()
