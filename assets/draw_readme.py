"""Draw the pictures of the README: ./run pictures.

Beside them, texts.json keeps what stands in them: by it a test notices when they are out of date.
"""

from __future__ import annotations

import io
import json
import re
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

import robsim
from robsim.cli.demo_run import simulate_demo
from robsim.plotting import _style as style

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "assets" / "readme"


def figures() -> dict[str, Figure]:
    """Return the figures by the names of their files."""
    return {"demo.jpg": demo_figure(), "traces.png": traces_figure()}


@style.applied
def demo_figure() -> Figure:
    """The demo: the last frame with the path, and the convergence of the parameters."""
    sim = simulate_demo()
    figure = style.NotebookFigure(figsize=(11, 4.6))
    left, right = figure.subfigures(1, 2, width_ratios=(1, 1.6))
    step, robot = sim.last_step, sim.robot
    robsim.plot_frame(
        sim.frame,
        ax=left.add_subplot(),
        blobs=step.blobs,
        measurement=step.measurement,
        outline=robot.to_robot_frame(robot.outline),
        trace=sim.trace,
    )
    right.suptitle("How the estimated parameters approach the true values")
    robsim.plot_parameters(sim.trace, axes=right.subplots(3, sharex=True))
    return figure


def traces_figure() -> Figure:
    """The figure that the first block of the README draws."""
    block = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert block is not None
    names: dict[str, Figure] = {}
    exec(block[1].replace("robsim.plot_traces", "figure = robsim.plot_traces"), names)
    return names["figure"]


def texts(figure: Figure) -> list[str]:
    """Return what stands in a figure, tick labels left out."""
    ticks = {
        label
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
        for label in (*axis.get_majorticklabels(), *axis.get_minorticklabels())
    }
    found = [text for text in figure.findobj(Text) if text not in ticks and text.get_visible()]
    return [text.get_text() for text in found if text.get_text()]


def picture(figure: Figure) -> Image.Image:
    """Return a figure as an image, as a notebook shows it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", bbox_inches="tight")
    return Image.open(buffer).convert("RGB")


def main() -> None:
    """Write the pictures and their texts."""
    FOLDER.mkdir(exist_ok=True)
    drawn = figures()
    for name, figure in drawn.items():
        image = picture(figure)
        if name.endswith(".png"):
            image.quantize(128, dither=Image.Dither.NONE).save(FOLDER / name, optimize=True)
        else:  # noise, of which a PNG is large
            image.save(FOLDER / name, quality=80, subsampling=0, optimize=True)
        print(f"{FOLDER / name}: {(FOLDER / name).stat().st_size / 1000:.0f} kB")
    content = {name: texts(figure) for name, figure in drawn.items()}
    (FOLDER / "texts.json").write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
