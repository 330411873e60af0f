"""The measured run, and the number in its picture."""

from __future__ import annotations

import time

from robsim._core import DriveAround, Step, reduced
from robsim.gui._link import jpeg
from robsim.gui.panels.run.camera import Shot
from robsim.gui.panels.settings.estimator import default_estimator
from robsim.gui.panels.view import PanelView
from robsim.simulation import Simulation
from robsim.vision.imaging.images import Pixels

BITS = 16
_CELL = 0.02  # of the picture's width

# Reads the number in each animation frame, and notes when another one is seen. Of the canvas it
# takes what shows the picture, which is the largest square in its middle.
SAMPLER = (
    """([bits, cell]) => {
  const small = document.createElement("canvas");
  small.width = bits; small.height = 1;
  const context = small.getContext("2d", { willReadFrequently: true });
  const seen = (window.robsimSeen = []);
  window.robsimBegan = Date.now();
  let last = -1;
  const look = () => {
    const canvas = document.querySelector(".robsim-camera canvas");
    if (canvas) {
      const side = Math.min(canvas.width, canvas.height);
      const left = (canvas.width - side) / 2, top = (canvas.height - side) / 2;
      const [width, height] = [bits * cell * side, 0.4 * cell * side];
      context.drawImage(canvas, left, top + 0.3 * cell * side, width, height, 0, 0, bits, 1);
      const { data } = context.getImageData(0, 0, bits, 1);
      let number = 0;
      for (let i = 0; i < bits; i++) if (data[4 * i] > 127) number |= 1 << i;
      if (number != last) seen.push([(last = number), Date.now()]);
    }
    requestAnimationFrame(look);
  };
  look();
}""",
    [BITS, _CELL],
)


def stamped_picture(shot: Shot, width: int) -> bytes:
    """Return the picture of a step with its number at the top left: lowest bit first, white = 1."""
    assert shot.frame is not None
    pixels = reduced(shot.frame, width).copy()
    _draw(pixels, shot.k & (1 << BITS) - 1)
    return jpeg(pixels)


def _draw(pixels: Pixels, number: int) -> None:
    cell = _CELL * pixels.shape[1]
    for bit in range(BITS):
        columns = slice(round(bit * cell), round((bit + 1) * cell))
        pixels[: round(cell), columns] = 255 if number >> bit & 1 else 0


_SPEED = 6.0  # times dt = 0.2 s: 30 steps/s

#: Step -> when it was done (ms), and the processor time of the process by then (s).
Steps = dict[int, tuple[float, float]]


def measured_view() -> tuple[PanelView, Steps]:
    """Return a panel with all stages on and numbered pictures, and the times of its steps."""
    simulation = Simulation(control=DriveAround(), measure=True, estimate_parameters=True, seed=1)
    simulation.estimate_state = default_estimator(simulation)
    view = PanelView(simulation, speed=_SPEED)
    steps: Steps = {}

    def note(step: Step) -> None:
        steps[step.k] = 1000 * time.time(), time.process_time()

    view.driver.on_step.insert(0, note)
    view.camera.encode = stamped_picture  # type: ignore[method-assign]
    return view, steps
