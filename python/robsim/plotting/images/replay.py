"""`play` and `annotated_frames`: a run as a clip in a notebook, or as frames for a video."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from robsim._core import Estimate, Frame, Measurement
from robsim.base.checks import check_bool, check_int
from robsim.plotting.images.overlay import draw_overlay
from robsim.plotting.style import check_source
from robsim.simulation import Simulation
from robsim.simulation.runner import Runner
from robsim.trace import Trace
from robsim.trace.units import length_format
from robsim.vision.imaging.clip import Clip
from robsim.vision.imaging.images import Pixels


def annotated_frames(
    frames: Iterable[Frame | None], trace: Trace, *, simulation: Runner
) -> Iterator[Pixels]:
    """Return the frames of a run with the measured and estimated poses drawn onto them.

    Parameters
    ----------
    frames : iterable of Frame
        The frames, one for each step of the trace. None = no frame in this step.
    trace : Trace
        The run.
    simulation : Simulation or Experiment
        The finished run: its robot's outline and detected blobs are drawn.

    Returns
    -------
    iterator of array (H, W, 3) of uint8
        RGB, drawn one by one.

    Raises
    ------
    TypeError
        If an argument, or one of the frames, has the wrong type.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, measure=True)
    >>> frames = [sim.step().frame for _ in range(3)]
    >>> images = list(robsim.plotting.annotated_frames(frames, sim.trace, simulation=sim))
    >>> len(images), images[0].shape
    (3, (1200, 1200, 3))
    """
    check_source("frames", frames, Iterable)
    check_source("trace", trace, Trace)
    check_source("simulation", simulation, Runner)
    return _annotated(frames, trace, simulation)


def _annotated(frames: Iterable[Any], trace: Trace, simulation: Runner) -> Iterator[Pixels]:
    robot = simulation.robot
    is_tracked = trace.is_tracked
    outline = robot.to_robot_frame(robot.outline)
    told, trace = trace, trace.in_unit("px")
    measured, estimated, covariance = trace.pose_measured, trace.pose_estimated, trace.covariance
    for i, frame in zip(range(len(trace)), frames, strict=False):
        if frame is None:
            continue
        check_source(f"frames[{i}]", frame, Frame)
        is_estimated = np.isfinite(estimated[i]).all()
        yield draw_overlay(
            frame,
            measurement=Measurement(measured[i]) if trace.seen[i] else None,
            blobs=simulation.find_blobs(frame) if is_tracked else None,
            outline=outline,
            path=measured[: i + 1, :2],
            estimate=Estimate(estimated[i], covariance[i]) if is_estimated else None,
            text=_caption(told, i),
        )


def _caption(trace: Trace, i: int) -> str:
    text = f"k {trace.k[i]}   t {trace.t[i]:.1f} s"
    if trace.seen[i]:
        (x, y, heading), unit = trace.pose_measured[i], trace.info.unit
        spec = length_format(unit, 1)
        text += f"   x {x:{spec}}  y {y:{spec}} {unit}   heading {np.rad2deg(heading):.1f} deg"
    return text


def play(
    simulation: Simulation,
    *,
    start: int = 0,
    stop: int | None = None,
    overlay: bool = True,
    width: int = 480,
) -> Clip:
    """Return a run as a clip that plays in a notebook, in real time.

    The frame rate is limited to 0.1..60 frames per second. So the clip plays slower than real time
    if `dt` is below 1/60 s, and faster if `dt` is above 10 s.

    Parameters
    ----------
    simulation : Simulation
        A simulation that has run; its frames are rendered again.
    start, stop : int, optional
        The steps start..stop - 1. Default: all steps.
    overlay : bool
        Draw the measured and estimated poses.
    width : int
        Width of the clip (px).

    Returns
    -------
    robsim.vision.Clip
        The clip.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type, or the run has no such steps.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, control=robsim.DriveAround(), measure=True)
    >>> trace = sim.run(10)
    >>> robsim.play(sim, stop=5)
    <Clip: 5 frames of 480 x 480 px, ... kB>
    """
    check_source("simulation", simulation, Simulation)
    trace = simulation.trace
    first = check_int("start", start, minimum=0, maximum=len(trace))
    end = len(trace) if stop is None else check_int("stop", stop, minimum=0, maximum=len(trace))
    trace = trace[first:end]
    frames: Iterable[Frame | Pixels] = (simulation.render_step(int(k)) for k in trace.k)
    if check_bool("overlay", overlay):
        frames = annotated_frames(
            frames,  # type: ignore[arg-type]
            trace,
            simulation=simulation,
        )
    return Clip(frames, fps=min(60.0, max(0.1, 1 / trace.info.dt)), width=width)
