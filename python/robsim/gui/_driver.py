"""The owner of a run's thread: it steps, and executes commands between two steps."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeVar

from robsim._core import HaltedError, Step
from robsim.base.checks import check_float
from robsim.gui._worker import Worker, at_work
from robsim.simulation import Experiment, Simulation
from robsim.simulation.callbacks.errors import callback_of
from robsim.simulation.slots import AT_START
from robsim.simulation.time_limit import TimeLimit

if TYPE_CHECKING:
    from robsim.gui.panels.record import Record


class Playback:
    """Plays the steps of a record, with the part of a `Simulation` required by a `Driver`.

    It starts at the last step, like a finished run; the next `step` returns the first step.
    """

    SLOTS = ()  # a record calls nothing
    stage = "world"

    def __init__(self, record: Record) -> None:
        self._record = record
        self._at = self.n_steps - 1
        self._next = 0
        self._shown: Step | None = None

    @property
    def n_steps(self) -> int:
        return self._record.n_steps

    @property
    def last_step(self) -> Step:
        """The displayed step."""
        if self._shown is None:
            self._shown = self._step(self._at)
        return self._shown

    def step(self) -> Step:
        """Go to the next step; EOFError after the last step, then start again."""
        if self._next >= self.n_steps:
            self._next = 0
            raise EOFError("the record has ended")
        self.seek(self._next)
        return self.last_step

    def step_stage(self) -> str:
        """Go to the next step, because a record has no stages."""
        self.step()
        return self.stage

    def seek(self, k: int) -> None:
        self._at, self._next, self._shown = k, k + 1, None

    def _step(self, k: int) -> Step:
        try:
            frame = self._record.frame(k)
        except LookupError:
            frame = None
        return self._record.step(k, frame)

    def reset(self) -> None:
        self.seek(0)

    def stop(self) -> bool:
        """Do nothing: steps are short, so nothing is interrupted."""
        return False


State = Literal["paused", "running", "ended", "failed", "closed"]
T = TypeVar("T")
SPEED = 5.0  # times real time
LIMIT = 30.0  # s for a callback's call, unless the run has its own limit.
_STAGE_PAUSE = 0.3  # s between two animated stages
_CATCH_UP = 0.1  # s of delay that are caught up; longer delays are dropped
_LONGEST_GAP = 2.0  # s of waiting between two frames: a record may have pauses
_CHUNK = 0.02  # s of steps at a time, at full speed
_LARGEST_CHUNK = 10_000  # steps


class Driver(Worker):
    """Runs a simulation or an experiment in a separate thread.

    Commands may come from any thread. They return a future at once. The thread executes the
    commands between two steps. An exception of a callback pauses the run and becomes `error`, not
    the future's exception. The next `start` or `step` repeats the failed stage.

    `speed` is a multiple of real time; inf = as fast as possible. Until the driver is closed, other
    code must use the `runner` only through `call`.
    """

    _thread_name: ClassVar[str] = "robsim driver"

    def __init__(self, runner: Simulation | Experiment | Playback, *, speed: float = SPEED) -> None:
        super().__init__()
        self.runner = runner
        # Called in the thread. In an animated run, the slots of the start also appear as stages.
        self.on_step: list[Callable[[Step], None]] = []
        self.on_stage: list[Callable[[str, Step], None]] = []
        self.on_state: list[Callable[[Driver], None]] = []
        self.on_reset: list[Callable[[], None]] = []  # an exception prevents it
        self._state: State = "paused"
        self._error: BaseException | None = None
        self._was_ended = False  # whether a command ended the newest run
        self._stops_seen = self._n_stops
        self._since = self._gap = 0.0  # due time and duration of the newest step (s)
        self._chunk = 1
        self._animates = False
        self._unseen: deque[str] = deque()  # stages of the start that are still to be animated
        self.speed = speed
        #: The limit of the calls of callbacks, which knows the current call.
        self.limit = None if isinstance(runner, Playback) else runner._time_limit
        self._own_limit = None if isinstance(runner, Playback) or self.limit else TimeLimit(LIMIT)
        if self._own_limit is not None:
            self.limit = self._own_limit
            self._limit_calls(self.limit)

    @property
    def state(self) -> State:
        """``"paused"``, ``"running"``, ``"ended"`` (no more frames), ``"failed"``, ``"closed"``."""
        return self._state

    @property
    def error(self) -> BaseException | None:
        """The exception that ended the run if `state` is ``"failed"``."""
        return self._error

    @property
    def has_motors(self) -> bool:
        return isinstance(self.runner, Experiment) and self.runner._motors is not None

    @property
    def is_live(self) -> bool:
        return isinstance(self.runner, Experiment) and self.runner.is_live

    @property
    def n_waiting(self) -> int:
        return len(self._jobs)

    @property
    def is_busy(self) -> bool:
        """Whether the run continues, or a command is being executed."""
        return self._state == "running" or self._is_working or bool(self._jobs)

    @property
    def waited_for(self) -> float | None:
        """Since when a pause or reset has waited for the current call (monotonic clock, s)."""
        with self._wake:
            asked = (getattr(job, "asked", None) for job in self._jobs)
            return min((at for at in asked if at is not None), default=None)

    @property
    def is_stopped(self) -> bool:
        """Whether `stop_robot` stopped the robot, without a later command to move."""
        return self._n_stops != self._stops_seen

    @property
    def speed(self) -> float:
        """Multiple of real time; inf = as fast as possible."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        is_endless = isinstance(speed, float) and speed == math.inf
        checked = speed if is_endless else check_float("speed", speed, exclusive_minimum=0)
        with self._wake:
            self._speed = checked
            self._since = max(self._since, time.monotonic() - self._gap / checked)  # no burst
            self._wake.notify()

    @property
    def animates(self) -> bool:
        """Whether the run shows stage after stage, slowly enough for watching."""
        return self._animates

    @animates.setter
    def animates(self, animates: bool) -> None:
        with self._wake:
            self._animates = animates
            self._wake.notify()

    def prepare(self) -> Future[None]:
        """Run the slots of the start, and show the initial state."""
        return self.call(lambda: self._attempt(self._show_start))

    def start(self) -> Future[None]:
        return self._move(lambda: self._set("running"), ends_run=False)

    def pause(self) -> Future[None]:
        """Stop after the current step; in an experiment, also stop the robot."""
        return self._command(self._pause, ends_call=True)

    def step(self) -> Future[None]:
        """Pause, and run one step."""
        return self._move(lambda: self._once(self._one_step))

    def step_stage(self) -> Future[None]:
        """Pause, and run one stage of a step."""
        return self._move(lambda: self._once(self._one_stage))

    def reset(self) -> Future[None]:
        """Pause, and return to the start. The future raises if that is impossible."""
        return self._command(self._reset, ends_call=True)

    def forget(self, error: BaseException) -> Future[None]:
        """Become paused if this error is still the newest: its cause is gone."""
        return self.call(lambda: self._set("paused") if self._error is error else None)

    def stop_robot(self) -> Future[None]:
        """Stop the robot at once, in this thread, then pause; raises like `Experiment.stop_robot`.

        Earlier commands to move are cancelled.
        """
        try:
            if isinstance(self.runner, Experiment):
                self.runner.stop_robot()
        finally:
            paused = self._command(self._pause, first=True, ends_call=True)
        return paused

    def call(self, function: Callable[[], T]) -> Future[T]:
        """Call a function in the thread, between two steps; `close` may cancel the call."""
        # Interrupting a run stops its robot, so looks and settings must not interrupt.
        return self._command(function, ends_run=not self.has_motors)

    def ask(self, function: Callable[[], T]) -> T:
        """Call a function between two steps, and wait for its result.

        In the thread itself, and after the end, the call runs at once.
        """
        if self.is_here:
            return function()
        try:
            return self.call(function).result()
        except CancelledError:
            self.close()  # the current step may still run
            return function()

    def _command(
        self,
        function: Callable[[], T],
        *,
        ends_run: bool = True,
        ends_call: bool = False,
        first: bool = False,
    ) -> Future[T]:
        if self._is_elsewhere:
            raise RuntimeError("this forked process cannot use its parent's run; create a new run")
        command = _Command(self, function, ends_run, time.monotonic() if ends_call else None)
        if not self.post(command, first=first):
            command.answer.cancel()
        if ends_run and self.is_here and self.runner.stop():  # a callback pauses its own run
            self._was_ended = True
        return command.answer

    def _move(self, move: Callable[[], None], *, ends_run: bool = True) -> Future[None]:
        """Do something that may move the robot, unless the robot is stopped meanwhile."""
        stops = self._n_stops

        def do() -> None:
            if self._n_stops == stops:
                self._stops_seen = stops
                move()

        return self._command(do, ends_run=ends_run)

    @property
    def _n_stops(self) -> int:
        return self.runner._n_stops if isinstance(self.runner, Experiment) else 0

    def _end(self) -> None:
        commands, self._jobs = self._jobs, deque()
        super()._end()
        for command in commands:
            assert isinstance(command, _Command)
            command.answer.cancel()

    def _limit_calls(self, limit: TimeLimit | None) -> None:
        assert not isinstance(self.runner, Playback)
        self.runner._limit_calls(limit)

    # In the thread.

    def _work(self) -> None:
        # All steps share one watchdog.
        with nullcontext() if self.limit is None else self.limit.watching():
            super()._work()

    def _due(self) -> float:
        if self._state != "running":
            return math.inf
        return self._since + (_STAGE_PAUSE if self._animates else self._pause_after_step)

    @property
    def _pause_after_step(self) -> float:
        return 0.0 if self.is_live else self._gap / self._speed

    def _do_due(self) -> None:
        if self.is_stopped:
            self._pause()
        else:
            self._attempt(self._advance)

    def _finish(self) -> None:
        try:
            self._stop_robot()
        except BaseException as error:  # any error of the user's motors
            self.report(error)
        if self._own_limit is not None:
            self._own_limit.seconds = math.inf  # slots of the start keep the limit
            self._limit_calls(None)
        self._set("closed")

    def _attempt(self, advance: Callable[[], None]) -> None:
        self._was_ended = False
        try:
            with self._looking_up():
                advance()
        except BaseException as error:  # also a KeyboardInterrupt raised by a callback
            is_callback = callback_of(error) is not None
            if isinstance(error, EOFError) and not is_callback:
                self._set("ended")
            elif isinstance(error, HaltedError) and self.is_stopped:
                self._pause()
            elif is_callback or not self._was_ended:  # an interrupted wait for a frame is no error
                self._fail(error)

    def _looking_up(self) -> AbstractContextManager[None]:
        if isinstance(self.runner, Playback):
            return nullcontext()
        return self.runner._looking_up(self._look_up)

    def _look_up(self, _: int) -> None:
        """Interrupt the run for a reason to end it; called about every 50 ms during a step."""
        if self.is_stopped and isinstance(self.runner, Experiment):
            self.runner._halt()
        with self._wake:
            is_cut = self._is_over or any(getattr(job, "ends_run", False) for job in self._jobs)
        if is_cut and self.runner.stop():
            self._was_ended = True

    def _advance(self) -> None:
        if self._animates and self._unseen:
            self._tell_stage(self._unseen.popleft())
        elif self._animates:
            self._one_stage()
        elif math.isinf(self._speed) and isinstance(self.runner, Simulation):
            self._many_steps(self.runner)
        else:
            self._one_step()

    def _once(self, advance: Callable[[], None]) -> None:
        self._set("paused")
        self._attempt(advance)

    def _one_step(self) -> None:
        self._tell_step(self.runner.step())

    def _many_steps(self, simulation: Simulation) -> None:
        started = time.monotonic()
        simulation.run(self._chunk)
        took = time.monotonic() - started
        growth = min(2.0, _CHUNK / max(took, 1e-6))
        self._chunk = min(max(1, int(self._chunk * growth)), _LARGEST_CHUNK)
        self._tell_step(simulation.last_step)

    def _one_stage(self) -> None:
        self._unseen.clear()
        self._tell_stage(self.runner.step_stage())
        if self.runner.stage == "world":  # the last stage of the step
            self._tell(self.on_step, self.runner.last_step)

    def _show_start(self) -> None:
        step = self.runner.last_step  # runs the slots of the start
        if not self.runner.n_steps:
            self._unseen = deque(slot for slot in AT_START if slot in self.runner.SLOTS)
        is_late = isinstance(self.runner, Simulation) and self.runner.scenario.camera_delay
        if (isinstance(self.runner, Experiment) or is_late) and not self.runner.n_steps:
            self._tell(self.on_state, self)  # no frame has arrived yet
        else:
            self._tell(self.on_step, step)

    def _tell_stage(self, stage: str) -> None:
        self._since = time.monotonic()
        self._tell(self.on_stage, stage, self.runner.last_step)

    def _tell_step(self, step: Step) -> None:
        self._unseen.clear()
        now = time.monotonic()
        self._since = min(now, max(self._since + self._pause_after_step, now - _CATCH_UP))
        self._gap = min(step.dt, _LONGEST_GAP)
        self._tell(self.on_step, step)

    def _tell(self, listeners: Sequence[Callable[..., None]], *news: object) -> None:
        for listener in listeners:
            self.guarded(listener, *news)

    def _pause(self) -> None:
        try:
            self._stop_robot()
        except BaseException as error:
            self._fail(error)
        else:
            self._set("paused" if self._state == "running" else self._state)

    def _reset(self) -> None:
        self._pause()
        try:
            for begin in self.on_reset:
                begin()
            self.runner.reset()
        except BaseException as error:
            if callback_of(error) is None:
                raise
            self._fail(error)
        else:
            self._set("paused")
            self._attempt(self._show_start)

    def _stop_robot(self) -> None:
        if isinstance(self.runner, Experiment) and not self.runner.is_running:
            self.runner._stop_robot(None)

    def _fail(self, error: BaseException) -> None:
        self._error = error
        self._set("failed")

    def _set(self, state: State) -> None:
        if state == "running" and self._state != "running":
            self._since, self._gap = time.monotonic(), 0.0
        if state != "failed":
            self._error = None
        self._state = state
        self._tell(self.on_state, self)


class _Command:
    """A job with an answer; `ends_run` interrupts a wait for a frame or a chunk of steps.

    `asked` is the time of the command, if the command also ends a hanging callback.
    """

    def __init__(
        self, driver: Driver, function: Callable[[], Any], ends_run: bool, asked: float | None
    ) -> None:
        self.answer = _Answer(driver)
        self.ends_run, self.asked = ends_run, asked
        self._function = function

    def __call__(self) -> None:
        if not self.answer.set_running_or_notify_cancel():
            return
        try:
            result = self._function()
        except BaseException as error:
            self.answer.set_exception(error)
        else:
            self.answer.set_result(result)


class _Answer(Future[Any]):
    """A future that raises instead of waiting endlessly."""

    def __init__(self, driver: Driver) -> None:
        super().__init__()
        self._driver = driver

    def result(self, timeout: float | None = None) -> Any:
        self._check_thread()
        return super().result(timeout)

    def exception(self, timeout: float | None = None) -> BaseException | None:
        self._check_thread()
        return super().exception(timeout)

    def _check_thread(self) -> None:
        if not self.done() and self._driver.is_here:
            raise RuntimeError(
                "a callback cannot wait for a command to its run, because the run waits for the "
                "callback"
            )


def pause_all() -> None:
    for worker in at_work():
        if isinstance(worker, Driver):
            worker.pause()
