"""The answers of the notebook 08_live, and mistakes that students make."""

import numpy as np

from robsim.teach.exercises.exercise import exercise


def wishes(rng):
    """Return wishes; some last voltages are above the limit, as after a change of limits."""
    voltage = rng.uniform(1, 2)
    last = rng.choice((0.95, 0.99, 1.3)) * voltage * rng.choice((-1, 1))
    return rng.uniform(-3, 3), last, voltage, rng.uniform(1.5, 3), 0.05


def step_first(wanted, last, voltage, slew_rate, dt):
    return min(max(wanted, last - slew_rate * dt), last + slew_rate * dt)


@exercise(
    cases=wishes,
    hint="There are two limits. Which of them must hold for the result?",
    mistakes={
        "The voltage has no limit: at most `voltage`, in both directions.": step_first,
        "The change has no limit: at most slew_rate times dt.": (
            lambda wanted, last, voltage, slew_rate, dt: np.clip(wanted, -voltage, voltage)
        ),
        "Limit the change first: the limit of the voltage must hold for the result.": (
            lambda wanted, last, voltage, slew_rate, dt: step_first(
                np.clip(wanted, -voltage, voltage), last, voltage, slew_rate, dt
            )
        ),
        "The change is limited upwards only.": lambda wanted, last, voltage, slew_rate, dt: np.clip(
            min(wanted, last + slew_rate * dt), -voltage, voltage
        ),
        "The slew rate is per second: multiply it by dt.": (
            lambda wanted, last, voltage, slew_rate, dt: np.clip(
                np.clip(wanted, last - slew_rate, last + slew_rate), -voltage, voltage
            )
        ),
        "This limits the change, and forgets the last voltage: add it.": (
            lambda wanted, last, voltage, slew_rate, dt: np.clip(
                np.clip(wanted - last, -slew_rate * dt, slew_rate * dt), -voltage, voltage
            )
        ),
    },
)
def limited(wanted, last, voltage, slew_rate, dt):
    """Return the voltage that a motor gets (V)."""
    change = np.clip(wanted - last, -slew_rate * dt, slew_rate * dt)
    return np.clip(last + change, -voltage, voltage)


def times(rng):
    t = 0.05 * np.arange(10) + 3
    t_sent = t + rng.uniform(0.03, 0.09, 10)
    t_sent[rng.integers(10)] = np.nan
    return t, t_sent, 0.05


@exercise(
    cases=times,
    hint="How does numpy take a mean without nan? Which of both times is the later one?",
    mistakes={
        "One nan makes the mean nan: leave such steps out.": (
            lambda t, t_sent, dt: (t_sent - t).mean() / dt
        ),
        "This is in seconds: divide it by dt.": lambda t, t_sent, dt: np.nanmean(t_sent - t),
        "The sign is wrong: the input goes out after the exposure.": (
            lambda t, t_sent, dt: np.nanmean(t - t_sent) / dt
        ),
        "Multiplied by dt it is no number of steps: divide by it.": (
            lambda t, t_sent, dt: np.nanmean(t_sent - t) * dt
        ),
        "A step without an input is no delay of 0: leave it out.": (
            lambda t, t_sent, dt: np.nan_to_num(t_sent - t).mean() / dt
        ),
    },
)
def mean_delay(t, t_sent, dt):
    """Return the mean time from exposure t (N,) to sending t_sent (N,), in steps of dt."""
    return np.nanmean(t_sent - t) / dt
