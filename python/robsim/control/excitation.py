"""Open-loop controllers that excite the robot for parameter identification."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robsim._core import Step, cos, exp, log, sin
from robsim.base.checks import Floats, check_float, check_int
from robsim.base.seeds import random_bits

# Register length -> the cells that are fed back: primitive polynomials, x^7 + x^6 + 1 and so on.
_FEEDBACK_TAPS = {
    3: (3, 2),
    4: (4, 3),
    5: (5, 3),
    6: (6, 5),
    7: (7, 6),
    8: (8, 6, 5, 4),
    9: (9, 5),
    10: (10, 7),
    11: (11, 9),
    12: (12, 11, 10, 4),
}
_MAXIMUM_LINES = 1000
_SAMPLES_PER_PERIOD = 64  # of the sine of the highest frequency, to find the peak of the sum
_MAXIMUM_SEED = 2**63 - 1


@dataclass(frozen=True, kw_only=True)
class _Excitation:
    """The limits of the voltages, shared by all excitation controllers."""

    low: float = -0.5  # V
    high: float = 1.5  # V

    def __post_init__(self) -> None:
        low, high = check_float("low", self.low, "V"), check_float("high", self.high, "V")
        if low >= high:
            raise ValueError(f"low must be below high (V), got low={low:g} and high={high:g}")

    def _voltage(self, signal: float) -> float:
        """Return the voltage of a normalised signal: -1 = low, 1 = high."""
        middle, half_width = (self.high + self.low) / 2, (self.high - self.low) / 2
        # against rounding
        return float(min(max(middle + half_width * signal, self.low), self.high))


@dataclass(frozen=True, kw_only=True)
class PseudoRandomBinary(_Excitation):
    """Switches each motor between two voltages in a periodic pseudo-random binary sequence (PRBS).

    No other input within the same limits has more power. The right motor gets the left motor's
    sequence with a delay of half a period. Over a whole period the two voltages are almost
    uncorrelated. The path repeats with the period of the voltages, and is shifted a little in each
    period.

    Parameters
    ----------
    low, high : float
        The two voltages (V).
    hold : int
        Number of steps for which a voltage is held: about a time constant of the robot. The time
        constant of the default robot's turn rate is 5.5 steps.
    order : int
        Length of the shift register, 3..12: the period is ``hold * (2**order - 1)`` steps.
    seed : int
        Seed of the start position in the sequence.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range.

    Notes
    -----
    A maximum-length sequence has 2^(order-1) high and 2^(order-1) - 1 low bits in a period; with
    bits of +-1 the mean of bit(i) bit(i + shift) is -1/(2^order - 1) for every shift except
    multiples of the period. Source: Söderström and Stoica, System Identification, 1989, ch. 5.

    Examples
    --------
    >>> control = robsim.control.PseudoRandomBinary(hold=6)
    >>> trace = robsim.Simulation(boundary="unlimited", control=control).run(800)
    """

    hold: int = 6
    order: int = 7
    seed: int = 0
    _bits: NDArray[np.bool_] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_int("hold", self.hold, minimum=1, maximum=2**31 - 1)
        order = check_int(
            "order", self.order, minimum=min(_FEEDBACK_TAPS), maximum=max(_FEEDBACK_TAPS)
        )
        bits = _maximum_length_sequence(order)
        # the upper half of 32 bits times the length: uniform on 0..length - 1
        start = (_random_bits(self.seed) & 0xFFFFFFFF) * len(bits) >> 32
        object.__setattr__(self, "_bits", np.roll(bits, -start))

    @property
    def period(self) -> int:
        """Steps after which the voltages repeat."""
        return self.hold * len(self._bits)

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        n_bits = len(self._bits)
        left = step.k // self.hold % n_bits
        right = (left + n_bits // 2) % n_bits
        return self._level(left), self._level(right)

    def _level(self, i: int) -> float:
        return float(self.high if self._bits[i] else self.low)


def _maximum_length_sequence(order: int) -> NDArray[np.bool_]:
    """Return one period of a feedback shift register's output, 2^order - 1 bits."""
    register = [True] * order
    bits = []
    for _ in range(2**order - 1):
        bits.append(register[-1])
        feedback = sum(register[cell - 1] for cell in _FEEDBACK_TAPS[order]) % 2 == 1
        register = [feedback, *register[:-1]]
    return np.array(bits)


def _random_bits(seed: int) -> int:
    return next(random_bits(check_int("seed", seed, minimum=0, maximum=_MAXIMUM_SEED)))


@dataclass(frozen=True, kw_only=True)
class _Band(_Excitation):
    """The frequency band of the excitation, shared by `MultiSine` and `Chirp`."""

    minimum_frequency: float
    maximum_frequency: float

    def __post_init__(self) -> None:
        super().__post_init__()
        low = check_float("minimum_frequency", self.minimum_frequency, "Hz", exclusive_minimum=0)
        high = check_float("maximum_frequency", self.maximum_frequency, "Hz", exclusive_minimum=0)
        if low >= high:
            raise ValueError(
                f"minimum_frequency must be below maximum_frequency (Hz), got {low:g} and {high:g}"
            )

    def _check_sampling(self, dt: float) -> None:
        if self.maximum_frequency * dt >= 0.5:
            raise ValueError(
                f"maximum_frequency must be below half the sampling frequency, {0.5 / dt:g} Hz "
                f"for dt = {dt:g} s, got {self.maximum_frequency:g}"
            )


@dataclass(frozen=True, kw_only=True)
class MultiSine(_Band):
    """Gives each motor a sum of sines of equal amplitude within a frequency band.

    The frequencies are the multiples of the minimum frequency: odd multiples for the left motor,
    even multiples for the right motor. Over a whole period, ``1 / minimum_frequency``, the two
    voltages are uncorrelated. The phases keep the crest factor low. The path repeats with the
    period of the voltages, and is shifted a little in each period.

    Parameters
    ----------
    low, high : float
        Limits of the voltages (V).
    minimum_frequency, maximum_frequency : float
        The band of the sines, which are spaced by the minimum frequency (Hz). The bandwidth of
        the default robot is 0.05 Hz for the speed and 0.16 Hz for the turn rate. If the period is
        a whole number of steps, no power leaks to other frequencies.
    seed : int
        Seed of the start position in the period.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range. Also raised during a run if the
        maximum frequency is not below half the sampling frequency.

    Notes
    -----
    Source of the phases: Schroeder, Synthesis of Low-Peak-Factor Signals and Binary Sequences with
    Low Autocorrelation, IEEE Trans. Information Theory 16(1), 1970. Sums of sines as inputs:
    Söderström and Stoica, System Identification, 1989, ch. 5; Ljung, System Identification, 1999,
    13.3.

    Examples
    --------
    >>> control = robsim.control.MultiSine(maximum_frequency=0.5)
    >>> trace = robsim.Simulation(boundary="unlimited", control=control).run(800)
    """

    minimum_frequency: float = 0.0125
    maximum_frequency: float = 0.3
    seed: int = 0
    _start: float = field(init=False, repr=False, compare=False)
    _waves: tuple[_Waves, _Waves] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        lines = math.floor(self.maximum_frequency / self.minimum_frequency + 1e-9)
        if not 2 <= lines <= _MAXIMUM_LINES:
            raise ValueError(
                f"maximum_frequency must be 2..{_MAXIMUM_LINES} times minimum_frequency (Hz), got "
                f"{self.maximum_frequency:g} and {self.minimum_frequency:g}"
            )
        multiples = np.arange(1, lines + 1)
        waves = (_schroeder(multiples[0::2]), _schroeder(multiples[1::2]))
        object.__setattr__(self, "_waves", waves)
        object.__setattr__(self, "_start", (_random_bits(self.seed) >> 11) * 2.0**-53)

    @property
    def frequencies(self) -> tuple[Floats, Floats]:
        """The frequencies of the left and of the right motor (Hz)."""
        left, right = (self.minimum_frequency * waves.multiples for waves in self._waves)
        return left, right

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        self._check_sampling(step.dt)
        periods = step.t * self.minimum_frequency + self._start
        left, right = (self._voltage(waves.at(periods)) for waves in self._waves)
        return left, right


@dataclass(frozen=True, kw_only=True, eq=False)
class _Waves:
    """A sum of sines, scaled to lie within -1..1."""

    multiples: Floats
    phases: Floats
    amplitude: float

    def at(self, periods: float) -> float:
        """Return the value at a time, in periods of the minimum frequency."""
        # amplitude sum of cos(2 pi multiple t/period + phase)
        angles = 2 * np.pi * self.multiples * (periods % 1.0) + self.phases
        return self.amplitude * math.fsum(cos(angles))


def _schroeder(multiples: NDArray[np.int64]) -> _Waves:
    """Return the sum of sines at these multiples of the minimum frequency, in Schroeder phases."""
    # phase(n) = -pi n (n - 1)/N for the sines n = 1..N
    n = np.arange(1, len(multiples) + 1)
    phases = -np.pi * n * (n - 1) / len(n)
    n_samples = _SAMPLES_PER_PERIOD * int(multiples[-1])
    spectrum = np.zeros(n_samples // 2 + 1, complex)
    spectrum[multiples] = np.exp(1j * phases) * n_samples / 2
    samples = np.abs(np.fft.irfft(spectrum))
    # The transform, whose last digits differ between machines, finds the largest; the sum gives it.
    largest = np.flatnonzero(samples >= (1 - 1e-9) * samples.max())
    turns = multiples * largest[:, np.newaxis] % n_samples / n_samples
    peak = max(abs(math.fsum(cos(angles))) for angles in 2 * np.pi * turns + phases)
    # peak <= maximum sample/cos(pi/samples per period): a bound on the values between the samples
    bound = peak / cos(math.pi / _SAMPLES_PER_PERIOD)
    return _Waves(multiples=multiples.astype(float), phases=phases, amplitude=1.0 / bound)


@dataclass(frozen=True, kw_only=True)
class Chirp(_Band):
    """Gives each motor a sine that sweeps a frequency band repeatedly.

    The left motor's sine sweeps up, and the right motor's sine sweeps down. Both sines spend the
    same time in each octave.

    Parameters
    ----------
    low, high : float
        Limits of the voltages (V).
    minimum_frequency, maximum_frequency : float
        The ends of the sweep (Hz). The bandwidth of the default robot is 0.05 Hz for the speed and
        0.16 Hz for the turn rate.
    duration : float
        Duration of one sweep (s).

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range. Also raised during a run if the
        maximum frequency is not below half the sampling frequency.

    Notes
    -----
    Source: Ljung, System Identification, 1999, 13.3, chirp signals; here the frequency grows
    exponentially with time instead of linearly.

    Examples
    --------
    >>> control = robsim.control.Chirp(duration=80)
    >>> trace = robsim.Simulation(boundary="unlimited", control=control).run(400)
    >>> robsim.batch_estimate(trace).batch[2, :2].round(3)
    array([ 1.833, -0.833])
    """

    minimum_frequency: float = 0.02
    maximum_frequency: float = 0.3
    duration: float = 80.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check_float("duration", self.duration, "s", exclusive_minimum=0)

    def frequencies(self, t: float) -> tuple[float, float]:
        """Return the frequencies of the left and of the right motor at a time (Hz).

        Parameters
        ----------
        t : float
            Time since the start (s).

        Raises
        ------
        TypeError, ValueError
            If `t` is not a finite number.
        """
        progress = check_float("t", t, "s") / self.duration % 1.0
        return self._frequency(progress), self._frequency(1 - progress)

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        self._check_sampling(step.dt)
        progress = step.t / self.duration % 1.0
        left, right = self._phase(progress), self._phase(1) - self._phase(1 - progress)
        return self._voltage(sin(left)), self._voltage(sin(right))

    def _frequency(self, progress: float) -> float:
        # f(t) = f_min (f_max/f_min)^(t/duration)
        return float(self.minimum_frequency * exp(progress * self._log_ratio()))

    def _phase(self, progress: float) -> float:
        # phase(t) = 2 pi integral of f from 0 to t = 2 pi duration (f(t) - f_min)/log(f_max/f_min)
        swept = self._frequency(progress) - self.minimum_frequency
        return 2 * math.pi * self.duration * swept / self._log_ratio()

    def _log_ratio(self) -> float:
        return float(log(self.maximum_frequency / self.minimum_frequency))
