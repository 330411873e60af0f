"""What the filters on the robot model share: the inputs that act, late or not, step by step."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from itertools import repeat
from typing import Any, Self

import numpy as np

from robsim._core import Estimate, RobotModel, Step, check_mean_interval, wrap_angle
from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.estimation.reference.estimator import StateEstimator
from robsim.estimation.reference.motion import RobotMotion
from robsim.trace.timing import check_delay, delayed


class _StepAhead:
    """A step with another estimate. No copy: that would have the frame drawn."""

    def __init__(self, step: Step, estimate: Estimate) -> None:
        self._step, self.estimate = step, estimate

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # copies and pickles ask for them before __init__
            raise AttributeError(name)
        return getattr(self._step, name)

    def __repr__(self) -> str:
        return f"{self._step!r} with the estimate {self.estimate!r}"


class ModelFilter(StateEstimator):
    """A filter that predicts with the robot model and the inputs.

    Attributes
    ----------
    motion : RobotMotion
        The motion model.
    """

    def __init__(self, model: RobotModel | None, *, input_delay: float, **options: Any) -> None:
        self.motion = RobotMotion(model)
        self._input_delay = check_delay("input_delay", input_delay)
        super().__init__(**options)

    @property
    def input_delay(self) -> float:
        """How late the inputs act (steps of the model)."""
        return self._input_delay

    def reset(self) -> None:
        """Return to the prior."""
        super().reset()
        self._time, self._n_steps = 0.0, 0
        # the inputs of the last steps of the model, as many as do not act to their end yet
        self._sent = np.zeros((int(np.ceil(self.input_delay)), 2))

    def _input_since(self, step: Step) -> Floats:
        last_u = np.asarray(step.last_u)
        if not self.input_delay or step.k == 0:
            return last_u
        # Of lost frames the input of the step before holds for several steps of the model.
        n_steps = self.motion.steps_in(step.dt)
        sent = np.vstack((self._sent, *repeat(last_u, n_steps)))
        self._sent = sent[n_steps:]
        return delayed(sent, self.input_delay)[-n_steps:]

    def _inputs(self, u: Floats, dt: float) -> Iterable[Floats]:
        """Return the input of each model step in a time (s); ValueError if it is none of it."""
        n_steps = self.motion.steps_in(dt)
        self._time += dt
        self._n_steps += n_steps
        check_mean_interval(self._time, self._n_steps, self.motion.T)
        return u if np.ndim(u) == 2 else repeat(u, n_steps)

    def predicted(self) -> Estimate:
        """Return the estimate for the time when an input that is sent now begins to act.

        From the newest estimate, with the inputs that are on their way, whose effect no frame has
        shown yet. Before the robot is seen, and without a delay, it is the newest estimate itself.
        Between two steps of the model state and covariance are interpolated linearly.

        Returns
        -------
        Estimate
            Pose, covariance and velocity `input_delay` steps after the newest step.
        """
        if not (self.input_delay and self._has_seen):
            return self._estimate()
        whole = int(self.input_delay)
        fraction = self.input_delay - whole
        ahead = self._copy()
        # What acts in the steps to come is known, but for what is sent from now on.
        to_come = delayed(np.vstack((self._sent, np.zeros((whole, 2)))), self.input_delay)
        for u in to_come[len(self._sent) :]:
            ahead.predict(u, self.motion.T)
        if fraction:
            before = ahead._copy()
            ahead.predict(self._sent[-1], self.motion.T)
            ahead._interpolate(before, fraction)
        return ahead._estimate()

    def ahead(self, step: Step) -> Any:
        """Return the step as a controller needs it whose inputs act late: with `predicted`.

        With it a controller that drives by ``step.estimate``, as `GoToPoint` and `FollowPath` do,
        compensates the delay: it sees where the robot will be when its input begins to act. What
        `estimate_state` returned, and the trace, remain those of the newest frame.

        Parameters
        ----------
        step : Step
            The step that the filter, as ``estimate_state``, has estimated.

        Returns
        -------
        object
            With all that the step has, but for its ``estimate``.

        Raises
        ------
        TypeError
            If `step` is not a Step.
        RuntimeError
            If this filter has not estimated the step.

        Examples
        --------
        >>> sim = robsim.Simulation(measure=True, motor_delay=2.4, seed=1)
        >>> from robsim.estimation.reference import ExtendedKalmanFilter
        >>> kalman_filter = ExtendedKalmanFilter(sim.model, input_delay=2.4)
        >>> go = robsim.GoToPoint(900, 300)
        >>> sim.estimate_state = kalman_filter
        >>> sim.control = lambda step: go(kalman_filter.ahead(step))
        >>> trace = sim.run(200)
        """
        if not isinstance(step, Step):
            raise TypeError(f"step must be a Step, got {quoted(step)}")
        if step.k != self._last_step:
            raise RuntimeError(
                f"the filter has not estimated step {step.k}: give it as estimate_state, too"
            )
        return _StepAhead(step, self.predicted())

    def _copy(self) -> Self:
        """Return a filter that goes on by itself."""
        return copy.copy(self)

    def _interpolate(self, before: Self, fraction: float) -> None:
        """Go back to a fraction of the way from an earlier state."""
        change = self.mean - before.mean
        change[2] = wrap_angle(change[2])
        self.mean = before.mean + fraction * change
        self.mean[2] = wrap_angle(self.mean[2])
        self.P = (1 - fraction) * before.P + fraction * self.P
