"""The class `Experiment`: the loop with external frames, and inputs to a real robot."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from os import PathLike
from threading import RLock
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._core import (
    ColorClass,
    Frame,
    Limits,
    MarkerLayout,
    MotorLink,
    Observation,
    RobotModel,
    RobotParameters,
)
from robsim.base.checks import Floats, check_bool
from robsim.base.files import as_path
from robsim.base.seeds import Seed, seed_sequence
from robsim.base.text import quoted
from robsim.base.warn import warn_user
from robsim.simulation import slots as slots
from robsim.simulation.called_motors import motors_of, stop_input_value
from robsim.simulation.frame_source import FrameSource
from robsim.simulation.mirrored_frames import mirrored_remark
from robsim.simulation.options import (
    OPTIONS,
    UNLIMITED,
    colors_value,
    limits_value,
    markers_value,
    step_count,
    timeout_value,
)
from robsim.simulation.runner import Runner
from robsim.simulation.slotted import suggests_names
from robsim.trace import Trace
from robsim.trace.columns import RECORDED
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot

if TYPE_CHECKING:
    from robsim.simulation.session_recording import SessionRecording

# Where a robot drives.
_FRAME_TIMEOUT = 1.0  # s, if the frames have no rate
_FRAME_INTERVALS = 3  # if they have
_LEAST_FRAME_TIMEOUT = 0.1  # s; no interpreter is punctual
_LONGEST_FRAME_TIMEOUT = 0.3  # s, by default; so long a robot drives when the line is cut, too


class Experiment(Runner):
    """A robot under a real camera, or a recording of one, driven by the callbacks of a simulation.

    Each step runs these stages in order. A frame arrives, then the parameter estimator gets the
    newest sample. The measurement evaluates the frame, and the state estimator updates its
    estimate. The controller returns an input, which is sent at once.

    The robot stops whenever a run ends: at the last step, the end of the frames, an exception,
    Ctrl-C, `stop`, a missing frame, or the end of a ``with`` block. After a call of `step`, the
    robot keeps driving until the next call, at most for `frame_timeout`.

    Parameters
    ----------
    frames : iterable of Frame, Observation or None
        One item for each step, requested after the previous step. None means that the step has no
        frame, so nothing is measured. An `Observation` can contain more data than a frame. The
        times ``t`` of the frames (s) must increase. If all times are missing, the frames are one
        sample time of the model apart. The iterable may have the attributes ``area``, ``dt`` and
        ``mm_per_px``. These set the work area, the default model's sample time and the length of a
        px.
    send : callable, optional
        ``send(u)``: brings an input, array (2,) in V, to the robot. The motors of `robsim.lab` work
        without the interpreter: they stop the robot even if a callback never releases the
        interpreter.
    stop_input : sequence of 2 floats, or None
        The input that stops the robot (V). With None, nothing is sent at the end of a run.
    frame_timeout : float, optional
        Maximum time from the arrival of a frame until the next one is taken (s), ten times as long
        for the first. After this time the robot is stopped, and the run ends with a TimeoutError.
        The limit covers late frames and slow callbacks. If `send` works without the interpreter,
        the limit also covers callbacks that hold the interpreter. A watchdog in a separate thread
        stops the robot, also between calls of `step`. Default: three times the ``dt`` of the
        frames, but at least 0.1 s, or 1 s if the ``dt`` is unknown. This default grows to twice the
        longest time between two frames, up to 0.3 s. Without `send` there is no limit (inf).
    limits : robsim.lab.Limits, optional
        Limits on the inputs, applied before sending. ``step.u`` and the trace have the inputs as
        sent.
    robot : str, path or RobotDefinition, optional
        Name of a robot, a folder with a ``robot.toml``, or a definition. Default: the robot chosen
        with ``robsim robots use``, initially ``"lab"``.
    area : tuple of int, optional
        Width and height of the work area (px). Default: ``frames.area`` if it exists, or 1200 x
        1200.
    seed : int, SeedSequence, Generator or None
        Seed of the random numbers of controllers and of `rng`. None = unpredictable.
    record : path, optional
        File of a session, which records frames, times, inputs and set-up step by step: see
        `robsim.trace.Session`. The file's name gets the suffix ``.mcap``; an existing file is an
        error. The file is complete when the ``with`` block ends, and readable even if the program
        crashes. A warning reports the first failed write immediately. Needs OpenCV.
    lossless : bool
        Whether the frames are recorded with a lossless codec.
    colors, markers, smoothing, time_limit
        As for `Simulation`.
    identify_from : str
        Source of the poses in the samples: ``"measurement"`` or ``"estimate"``. ``"truth"`` means
        the samples in the observations.
    model : RobotModel or RobotParameters, optional
        The model of the robot, instead of `define_model`. Default: the model of
        ``RobotParameters()``, with the ``dt`` of the frames if it is known.
    define_model : callable, optional
        ``define_model() -> RobotModel``, called once, at the start: the model that the robot's
        software believes in.
    init_parameter_estimator : callable, optional
        ``init_parameter_estimator(model) -> estimator``, called once, at the start: the object
        whose ``update(phi, y)`` estimates the parameters.
    estimate_parameters : callable or bool, optional
        ``estimate_parameters(step) -> (3, 5) or None``, called at each step: the parameters, None =
        no update. True: the estimator updates them.
    measure : callable or bool, optional
        ``measure(step) -> Measurement or None``, called at each step with a frame: the pose seen in
        it, None = not seen. True: the two markers are located.
    estimate_state : callable, optional
        ``estimate_state(step) -> Estimate``, called at each step: the pose and its covariance.
    control : callable, optional
        ``control(step) -> (u1, u2)``, called at each step, as the last stage: the voltages of the
        left and the right motor (V).

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or is out of range; the message names the
        argument.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     with robsim.lab.UdpMotors(lab.address) as motors:
    ...         experiment = robsim.Experiment(camera, send=motors)
    ...         experiment.control = robsim.GoToPoint(600, 300)
    ...         trace = experiment.run(3)
    >>> len(trace), trace.u.shape
    (3, (3, 2))
    """

    _GROUPS = RECORDED
    _AGAIN = "robsim.Experiment(frames, ...)"

    @suggests_names
    def __init__(
        self,
        frames: Iterable[Frame | Observation | None],
        *,
        send: Callable[[Floats], Any] | None = None,
        stop_input: Sequence[float] | None = (0.0, 0.0),
        frame_timeout: float | None = None,
        limits: Limits | None = None,
        # options: written by ./run stubs
        robot: str | PathLike[str] | RobotDefinition | None = None,
        seed: Seed = None,
        colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
        markers: MarkerLayout | RobotDefinition | str | PathLike[str] | None = None,
        smoothing: int | None = None,
        model: RobotModel | RobotParameters | None = None,
        # end
        area: tuple[int, int] | None = None,
        identify_from: str = "measurement",
        time_limit: float | None = None,
        record: str | PathLike[str] | None = None,
        lossless: bool = False,
        # slots: written by ./run stubs
        define_model: slots.DefineModel | None = None,
        init_parameter_estimator: slots.InitParameterEstimator | None = None,
        estimate_parameters: slots.EstimateParameters | None = None,
        measure: slots.Measure | None = True,
        estimate_state: slots.EstimateState | None = None,
        control: slots.Control | None = None,
        # end
    ) -> None:
        definition = as_robot(robot)
        check_bool("lossless", lossless)
        self._recording = None if record is None else _recording_in(record, lossless=lossless)
        timeout = timeout_value(frame_timeout, _default_timeout(frames, send))
        self._source = FrameSource(
            frames, area=area, is_polled=send is not None or not math.isinf(timeout)
        )
        self._model = OPTIONS["model"].checked(model)
        self._given_markers = markers_value(markers)
        self._next_look = 1  # at the frames, by the number of steps
        stops = stop_input_value(stop_input)
        self._motors = None if send is None else motors_of(send, stops)
        self._stopping = RLock()
        self._n_stops = 0  # how often `stop_robot` was called
        self._sent = {"stop_input": stops, "send": None if send is None else quoted(send)}
        super().__init__(
            _core.ExternalWorld(
                frames=self._source.native,
                motors=self._motors,
                frame_timeout=timeout,
                limits=None if limits is None else limits_value(limits),
                longest_timeout=timeout if frame_timeout else _LONGEST_FRAME_TIMEOUT,
            ),
            robot=definition,
            area=self._source.area,
            boundary="recorded",
            seed=seed_sequence(seed),
            colors=colors_value(colors),
            markers=self._given_markers or definition.marker_layout(),
            smoothing=OPTIONS["smoothing"].checked(smoothing),
            identify_from=OPTIONS["identify_from"].checked(identify_from),
            time_limit=time_limit,
        )
        # filled: written by ./run stubs
        self._fill_slots(
            define_model=define_model, init_parameter_estimator=init_parameter_estimator,
            estimate_parameters=estimate_parameters, measure=measure, estimate_state=estimate_state,
            control=control,
        )  # fmt: skip
        # end
        if self._recording is not None:
            self._core.set_observer(self._recording.add)

    def _change_vision(self, **changes: Any) -> None:
        self._core.check_thread()
        if self._recording is not None and self._recording.has_begun:
            (name,) = changes
            raise RuntimeError(
                f"{name} cannot be changed during the recording of a session: make a new "
                "Experiment with another file for record"
            )
        robot = changes.get("robot", self.robot)
        markers = self._given_markers or robot.marker_layout()
        self._look_for(robot, changes.get("colors", self.colors), markers)
        self._note_change(changes)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if self.stop():  # a run in another thread: it stops the robot itself
            while self.is_running:
                time.sleep(0.01)
        try:
            self._stop_robot(error)
        finally:
            if self._recording is not None:
                self._recording.close(self.trace)

    def run(self, steps: int | None = None, *, progress: bool | str = False) -> Trace:
        """Run some or all steps; a run continues where the previous run ended.

        Parameters
        ----------
        steps : int, optional
            Number of steps. Default: until the frames end.
        progress : bool or str
            Show a progress bar; a str is its label.

        Returns
        -------
        Trace
            All steps since the start.

        Raises
        ------
        Exception
            Any exception raised by a callback, by `frames` or by `send`. Its note names the
            callback and the step, and its attribute ``callback`` is a
            `robsim.simulation.FailedCallback`. `trace` keeps the previous steps. The next run
            repeats the failed stage in the same step, but not the earlier stages. With a live
            camera, the next run begins with a new frame, and the partial step is kept without an
            input.
        EOFError
            If `steps` is given and there are no more frames.
        TimeoutError
            If a frame does not come, or is not processed, within `frame_timeout`.
        RuntimeError
            If it is already running.

        Warns
        -----
        UserWarning
            If the frames end before `steps` steps are done, or are empty. If the first frame has no
            plane map and its size differs from the area's, or if frames seem to be in OpenCV's
            order, BGR.
            If results of callbacks are implausible, as in `Simulation.run`.
        robsim.vision.SmallMarkersWarning
            If the default measurement evaluates markers that are too small for the noise in the
            frames.
        """
        before = self.n_steps
        wanted = UNLIMITED if steps is None else step_count(steps)
        is_at_end = self._run(wanted, progress, steps)
        done = self.n_steps - before
        if is_at_end and steps is None and not self.n_steps:
            warn_user("frames gave no frame: there was nothing to run")
        if is_at_end and steps is not None and done < steps:
            if done == 0:
                raise EOFError("there are no more frames")
            warn_user(f"the frames ended after {done} of {steps} steps")
        if self.n_steps >= self._next_look:
            self._next_look = 2 * self.n_steps  # seldom, as it costs as much as some steps
            if remark := mirrored_remark(self):
                warn_user(remark)
        return self.trace

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        try:
            with ExitStack() as stack:
                with self._stopping:
                    stack.enter_context(super()._guarded())
                    if self._motors is not None and not self.is_running:
                        self._motors.resume()
                if self._pulse is not None:  # it may have been stopped before it could be
                    self._pulse(0)
                stack.enter_context(self._source.reading())
                yield
        except BaseException as error:
            self._tell_stop_error(error)
            raise
        self._tell_stop_error(None)

    def _run_guarded(self, steps: int, progress: bool | str, total: int | None) -> bool:
        pulse = self._pulse

        def look(done: int) -> None:
            if pulse is not None:
                pulse(done)
            self._tell_doubts()

        with self._looking_up(look):
            try:
                return super()._run_guarded(steps, progress, total)
            finally:
                if self._recording is not None:
                    self._recording.flush()

    @property
    def _doubts(self) -> list[str]:
        doubts = [*super()._doubts, *self._source.doubts]
        if isinstance(self._motors, MotorLink) and self._motors.is_silent:
            doubts.append(
                f"the robot at {self._motors.name} has not answered for a second: check the line "
                "and the robot's power"
            )
        return doubts

    def _prepare(self) -> None:
        try:
            super()._prepare()
            if self._recording is not None and not self.is_running:
                setup = self._source.described() | self._sent
                self._recording.begin(self, self.model, setup, is_live=self._source.is_live)
        except BaseException as error:
            if not self.is_running:  # step may have left the robot driving
                self._stop_robot(error)
            raise

    @property
    def is_live(self) -> bool:
        """Whether the source sets the pace of the frames, as a camera does.

        False for a recording, a session and your own frames, which are read on request.
        """
        return self._source.is_live

    def stop_robot(self) -> None:
        """Stop the robot at once, even during a callback; any thread may call this method.

        The current run sends no further input to the robot, and ends after the current step. If a
        callback is computing an input at that moment, the run raises a `robsim.lab.HaltedError`.
        The next `run` or `step` drives the robot again.

        Raises
        ------
        Exception
            The exceptions of `send`, if nothing is running; otherwise the run raises them.

        See Also
        --------
        stop : Ends a run after its step, and only then stops the robot.

        Notes
        -----
        A `send` of your own is called in the thread of the caller, maybe during another call in the
        thread of the run. The motors of `robsim.lab` need no interpreter to stop.

        Examples
        --------
        >>> frames = [robsim.Frame(np.zeros((64, 64, 3), np.uint8))] * 3
        >>> sent = []
        >>> experiment = robsim.Experiment(
        ...     frames, send=sent.append, control=lambda step: (0.5, 0.5), area=(64, 64)
        ... )
        >>> step = experiment.step()  # leaves the robot driving
        >>> experiment.stop_robot()
        >>> sent[-1]
        array([0., 0.])
        """
        self._n_stops += 1
        with self._stopping:  # no run begins meanwhile
            if not self._guarding.locked():
                self._stop_robot(None)
                return
        self._halt()

    def _halt(self) -> None:
        """Stop the robot in the middle of a run, and end the run after its step."""
        if self._motors is not None:
            self._motors.halt()
        self.stop()

    def _stop_robot(self, error: BaseException | None) -> None:
        self._core.stop_robot()
        self._tell_stop_error(error)

    def _tell_stop_error(self, error: BaseException | None) -> None:
        """Raise the error that occurred while stopping the robot, or note it in `error`."""
        if self._motors is None:
            return
        try:
            self._motors._check_stop()
        except BaseException as trouble:
            if error is None:
                trouble.add_note("in send, while stopping the robot")
                raise
            if not isinstance(trouble, KeyboardInterrupt):  # an interrupt: all was still sent
                error.add_note(
                    f"the robot could not be stopped: {type(trouble).__name__}: {trouble}"
                )

    def reset(self, *, seed: Seed = None) -> None:
        """Stop the robot and return to the start; the next run begins with the first frame.

        Parameters
        ----------
        seed : int, SeedSequence or Generator, optional
            Seed of the next run. Default: the same seed.

        Raises
        ------
        RuntimeError
            If `frames` can be read only once, and some frames have been read.
        """
        self._stop_robot(None)
        if self._recording is not None and self._recording.has_begun:
            raise RuntimeError("the recording of a session cannot restart: make a new Experiment")
        if self._source.is_spent:
            raise RuntimeError(
                "the frames can be read only once, but a reset reads them again: give a list or a "
                "Recording"
            )
        super().reset(seed=seed)
        self._source.restart()
        self._tell_stop_error(None)

    def _stage(self, slot: str, callback: Any) -> Any:
        if slot == "define_model" and callable(callback):
            return self._source.checked(callback)
        return super()._stage(slot, callback)

    def _default(self, slot: str) -> Any:
        if slot != "define_model":
            return None
        model = self._model
        if model is None:
            return self._source.model()
        given = RobotModel(model) if isinstance(model, RobotParameters) else model
        return self._source.checked(lambda: given)()

    def _check_source(self) -> None:
        if self.identify_from == "estimate":
            super()._check_source()  # measurements and samples may come with the frames
        if not self._is_on("control"):
            raise ValueError(
                "estimate_parameters needs the inputs of the robot: give control=..., or "
                "control=robsim.Replay(u) for inputs recorded with the frames"
            )

    def _lacks(self, problem: str) -> None:
        if self.is_live:
            super()._lacks(problem)
        self._source.lacks = problem  # an Observation may bring it

    def _check_stages(self) -> None:
        self._source.lacks = None
        super()._check_stages()
        if self._motors is not None and not self._is_on("control"):
            warn_user(
                "send was given, but there is no controller: nothing is sent; give control=..."
            )

    def _mm_per_px(self) -> float | None:
        return self._source.mm_per_px

    def _headings(self) -> int | None:
        return self._source.headings

    def _theta_true(self) -> ArrayLike:
        return np.full((3, 5), np.nan)


def _recording_in(path: str | PathLike[str], *, lossless: bool) -> SessionRecording:
    """Return the recorder of a session; only recording loads its module."""
    from robsim.simulation.session_recording import SessionRecording

    return SessionRecording(as_path(path, "record"), lossless=lossless)


def _default_timeout(frames: object, send: object) -> float:
    """Return the default of the option ``frame_timeout`` (s)."""
    if send is None:
        return math.inf
    dt = getattr(frames, "dt", None)
    return _FRAME_TIMEOUT if dt is None else max(_FRAME_INTERVALS * dt, _LEAST_FRAME_TIMEOUT)
