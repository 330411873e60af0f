"""Draw the pictures of the README: ./run pictures.

Beside them, contents.json keeps what is written and drawn in them: by it a test notices when they
are out of date.
"""

from __future__ import annotations

import io
import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "assets" / "readme"
PANEL, FILM = "panel.png", "drive.webp"


def figures() -> dict[str, Figure]:
    """Return the figures by the names of their files."""
    return {"traces.png": traces_figure()}


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
        for axis in figure.findobj(Axis)  # of secondary axes, too
        for label in (*axis.get_majorticklabels(), *axis.get_minorticklabels())
    }
    found = [text for text in figure.findobj(Text) if text not in ticks and text.get_visible()]
    return [text.get_text() for text in found if text.get_text()]


def marks(figure: Figure) -> list[str]:
    """Return what is drawn in a figure: each kind of mark with its colours, and how many."""
    return [
        f"axes {number}: {count} x {mark}"
        for number, axes in enumerate(figure.axes)
        for mark, count in Counter(_marks_in(axes)).items()
    ]


def _marks_in(axes: Axes) -> list[str]:
    found = [f"image of {image.get_array().shape[:2]}" for image in axes.images]
    for line in axes.lines:
        look = [f"line {to_hex(line.get_color())}", f"{len(line.get_xdata())} points"]
        if line.get_linestyle() != "None" and line.get_linewidth():
            look.append(f"{line.get_linestyle()} of {line.get_linewidth():g}")
        if line.get_marker() not in ("None", ""):
            look.append(f"marker {line.get_marker()} of {line.get_markersize():.1f}")
        found.append(", ".join(look))
    for patch in axes.patches:
        edge, face = _color(patch.get_edgecolor()), _color(patch.get_facecolor())
        found.append(f"{type(patch).__name__} {face}, edge {edge}")
    for band in axes.collections:
        found.append(f"{type(band).__name__} {[_color(color) for color in band.get_facecolor()]}")
    return found


def _color(color: Any) -> str:
    text = to_hex(color, keep_alpha=True)
    return "transparent" if text.endswith("00") else text


def picture(figure: Figure) -> Image.Image:
    """Return a figure as an image, as a notebook shows it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", bbox_inches="tight")
    return Image.open(buffer).convert("RGB")


def main() -> None:
    """Write the pictures and what is in them."""
    FOLDER.mkdir(exist_ok=True)
    drawn = figures()
    for name, figure in drawn.items():
        few = picture(figure).quantize(128, dither=Image.Dither.NONE)
        few.save(FOLDER / name, optimize=True)
    contents = {
        name: {"texts": texts(figure), "marks": marks(figure)} for name, figure in drawn.items()
    }
    import draw_film  # needs Chromium, as the next one does
    import draw_panel

    draw_film.save(FOLDER / FILM)
    panel, words = draw_panel.panel_picture()
    draw_panel.small(panel).save(FOLDER / PANEL, optimize=True)
    contents[PANEL] = {"texts": words}
    for name in contents:
        print(f"{FOLDER / name}: {(FOLDER / name).stat().st_size / 1000:.0f} kB")
    text = json.dumps(contents, indent=1, ensure_ascii=False)
    (FOLDER / "contents.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
