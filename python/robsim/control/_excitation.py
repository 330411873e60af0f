"""Controllers that excite everything."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats, check_choice, check_float, check_int
from robsim._core import DriveAround, Spin, Step

# Which cells of a shift register of so many cells are fed back: x^7 + x^6 + 1 and so on, primitive
# polynomials.
_FED_BACK = {
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
_MOST_LINES = 1000
_SAMPLES_PER_WAVE = 64  # of the fastest sine, where a peak is looked for
_MOST_SEED = 2**63 - 1


@dataclass(frozen=True, kw_only=True)
class _Excitation:
    """The limits within which the voltages stay."""

    low: float = -0.5  # V
    high: float = 1.5  # V

    def __post_init__(self) -> None:
        low, high = check_float("low", self.low, "V"), check_float("high", self.high, "V")
        if low >= high:
            raise ValueError(f"low must be below high (V), got low={low:g} and high={high:g}")

    def _voltage(self, share: float) -> float:
        """Return the voltage for -1 = low .. 1 = high."""
        middle, reach = (self.high + self.low) / 2, (self.high - self.low) / 2
        # against rounding
        return float(min(max(middle + reach * share, self.low), self.high))


@dataclass(frozen=True, kw_only=True)
class PseudoRandomBinary(_Excitation):
    """Switches each motor between two voltages, in a sequence that looks random and repeats.

    No other input within the same limits has as much power. The right motor gets the sequence of
    the left one, later by half a period: over a whole period the two are all but uncorrelated.
    The path repeats itself with the voltages, a bit farther on each time.

    Parameters
    ----------
    low, high : float
        The two voltages (V).
    hold : int
        Steps for which a voltage is held: about a time constant of the robot. That of the default
        robot's turn rate is 5.5 steps.
    order : int
        Cells of the shift register, 3..12: the sequence repeats after ``hold * (2**order - 1)``
        steps.
    seed : int
        Where in the sequence the run begins.

    Raises
    ------
    TypeError, ValueError
        If a value does not fit; the message names it.

    Notes
    -----
    A maximum-length sequence has 2^(order-1) high and 2^(order-1) - 1 low bits a period; with
    bits of +-1 the mean of bit(i) bit(i + shift) is -1/(2^order - 1) for every shift that is no
    whole period. Source: Soederstrom and Stoica, System Identification, 1989, ch. 5.

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
        order = check_int("order", self.order, minimum=min(_FED_BACK), maximum=max(_FED_BACK))
        bits = _maximum_length_sequence(order)
        start = _random(self.seed).integers(len(bits))
        object.__setattr__(self, "_bits", np.roll(bits, -start))

    @property
    def period(self) -> int:
        """Steps after which the voltages repeat."""
        return self.hold * len(self._bits)

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        count = len(self._bits)
        left = step.k // self.hold % count
        right = (left + count // 2) % count
        return self._level(left), self._level(right)

    def _level(self, i: int) -> float:
        return float(self.high if self._bits[i] else self.low)


def _maximum_length_sequence(order: int) -> NDArray[np.bool_]:
    """Return one period of the output of a shift register, 2^order - 1 bits."""
    register = [True] * order
    bits = []
    for _ in range(2**order - 1):
        bits.append(register[-1])
        fed_back = sum(register[cell - 1] for cell in _FED_BACK[order]) % 2 == 1
        register = [fed_back, *register[:-1]]
    return np.array(bits)


def _random(seed: int) -> np.random.Generator:
    return np.random.default_rng(check_int("seed", seed, minimum=0, maximum=_MOST_SEED))


@dataclass(frozen=True, kw_only=True)
class _Band(_Excitation):
    """The frequencies within which the power lies."""

    lowest_frequency: float
    highest_frequency: float

    def __post_init__(self) -> None:
        super().__post_init__()
        lowest = check_float("lowest_frequency", self.lowest_frequency, "Hz", exclusive_minimum=0)
        highest = check_float(
            "highest_frequency", self.highest_frequency, "Hz", exclusive_minimum=0
        )
        if lowest >= highest:
            raise ValueError(
                f"lowest_frequency must be below highest_frequency (Hz), got {lowest:g} and "
                f"{highest:g}"
            )

    def _check_sampling(self, dt: float) -> None:
        if self.highest_frequency * dt >= 0.5:
            raise ValueError(
                f"highest_frequency must be below half the sampling frequency, {0.5 / dt:g} Hz "
                f"for dt = {dt:g} s, got {self.highest_frequency:g}"
            )


@dataclass(frozen=True, kw_only=True)
class MultiSine(_Band):
    """Gives each motor a sum of equally strong sines, all at frequencies that you choose.

    They are the multiples of the lowest frequency: the odd ones for the left motor, the even ones
    for the right. Over a whole period, ``1 / lowest_frequency``, the two voltages are uncorrelated.
    The phases are such that the peaks stay low. The path repeats itself with the voltages, a bit
    farther on each time.

    Parameters
    ----------
    low, high : float
        Limits of the voltages (V).
    lowest_frequency, highest_frequency : float
        The sines lie within these (Hz), a lowest frequency apart; the default robot's speed
        follows up to 0.05 Hz, its turn rate up to 0.16 Hz. If the period is a whole number of
        steps, no power leaks to other frequencies.
    seed : int
        Where in the period the run begins.

    Raises
    ------
    TypeError, ValueError
        If a value does not fit; the message names it. At a step, if half the sampling frequency
        is not above the highest frequency.

    Notes
    -----
    Phases: Schroeder, Synthesis of Low-Peak-Factor Signals and Binary Sequences with Low
    Autocorrelation, IEEE Trans. Information Theory 16(1), 1970. Sums of sines as inputs:
    Soederstrom and Stoica, System Identification, 1989, ch. 5; Ljung, System Identification,
    1999, 13.3.

    Examples
    --------
    >>> control = robsim.control.MultiSine(highest_frequency=0.5)
    >>> trace = robsim.Simulation(boundary="unlimited", control=control).run(800)
    """

    lowest_frequency: float = 0.0125
    highest_frequency: float = 0.3
    seed: int = 0
    _start: float = field(init=False, repr=False, compare=False)
    _waves: tuple[_Waves, _Waves] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        lines = math.floor(self.highest_frequency / self.lowest_frequency + 1e-9)
        if not 2 <= lines <= _MOST_LINES:
            raise ValueError(
                f"highest_frequency must be 2..{_MOST_LINES} times lowest_frequency (Hz), got "
                f"{self.highest_frequency:g} and {self.lowest_frequency:g}"
            )
        multiples = np.arange(1, lines + 1)
        waves = (_schroeder(multiples[0::2]), _schroeder(multiples[1::2]))
        object.__setattr__(self, "_waves", waves)
        object.__setattr__(self, "_start", _random(self.seed).random())

    @property
    def frequencies(self) -> tuple[Floats, Floats]:
        """The frequencies of the left and of the right motor (Hz)."""
        left, right = (self.lowest_frequency * waves.multiples for waves in self._waves)
        return left, right

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        self._check_sampling(step.dt)
        period_done = step.t * self.lowest_frequency + self._start
        left, right = (self._voltage(waves.at(period_done)) for waves in self._waves)
        return left, right


@dataclass(frozen=True, kw_only=True, eq=False)
class _Waves:
    """A sum of sines within -1..1."""

    multiples: Floats
    phases: Floats
    amplitude: float

    def at(self, period_done: float) -> float:
        # amplitude sum of cos(2 pi multiple t/period + phase)
        angles = 2 * np.pi * self.multiples * (period_done % 1.0) + self.phases
        return float(self.amplitude * np.cos(angles).sum())


def _schroeder(multiples: NDArray[np.int64]) -> _Waves:
    """Return the sum of sines at these multiples of the lowest frequency."""
    # phase(n) = -pi n (n - 1)/N for the sines n = 1..N
    n = np.arange(1, len(multiples) + 1)
    phases = -np.pi * n * (n - 1) / len(n)
    samples = _SAMPLES_PER_WAVE * int(multiples[-1])
    spectrum = np.zeros(samples // 2 + 1, complex)
    spectrum[multiples] = np.exp(1j * phases) * samples / 2
    # peak <= highest sample/cos(pi/samples per wave): what may lie between two samples
    peak = np.abs(np.fft.irfft(spectrum)).max() / math.cos(math.pi / _SAMPLES_PER_WAVE)
    return _Waves(multiples=multiples.astype(float), phases=phases, amplitude=1.0 / float(peak))


@dataclass(frozen=True, kw_only=True)
class Chirp(_Band):
    """Gives each motor a sine that sweeps through all frequencies, over and over.

    The left motor's goes up, the right motor's down. Both spend the same time in each octave.

    Parameters
    ----------
    low, high : float
        Limits of the voltages (V).
    lowest_frequency, highest_frequency : float
        The ends of the sweep (Hz); the default robot's speed follows up to 0.05 Hz, its turn rate
        up to 0.16 Hz.
    duration : float
        Time of a sweep (s).

    Raises
    ------
    TypeError, ValueError
        If a value does not fit; the message names it. At a step, if half the sampling frequency
        is not above the highest frequency.

    Notes
    -----
    Source: Ljung, System Identification, 1999, 13.3, chirp signals; here the frequency grows
    exponentially with time in place of linearly.

    Examples
    --------
    >>> control = robsim.control.Chirp(duration=80)
    >>> trace = robsim.Simulation(boundary="unlimited", control=control).run(800)
    """

    lowest_frequency: float = 0.02
    highest_frequency: float = 0.3
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
        """
        done = t / self.duration % 1.0
        return self._frequency(done), self._frequency(1 - done)

    def __call__(self, step: Step) -> tuple[float, float]:
        """Return the voltages (u1, u2) of a step."""
        self._check_sampling(step.dt)
        done = step.t / self.duration % 1.0
        left, right = self._phase(done), self._phase(1) - self._phase(1 - done)
        return self._voltage(math.sin(left)), self._voltage(math.sin(right))

    def _frequency(self, done: float) -> float:
        # f(t) = lowest (highest/lowest)^(t/duration)
        ratio = self.highest_frequency / self.lowest_frequency
        return float(self.lowest_frequency * ratio**done)

    def _phase(self, done: float) -> float:
        # phase(t) = 2 pi integral of f from 0 to t
        #          = 2 pi duration (f(t) - lowest)/log(highest/lowest)
        swept = self._frequency(done) - self.lowest_frequency
        log_ratio = math.log(self.highest_frequency / self.lowest_frequency)
        return 2 * math.pi * self.duration * swept / log_ratio


_NAMES: dict[str, Callable[[], Callable[[Step], Any]]] = {
    "spin": Spin,
    "drive-around": DriveAround,
    "pseudo-random-binary": PseudoRandomBinary,
    "multi-sine": MultiSine,
    "chirp": Chirp,
}


def controller_named(name: str) -> Callable[[Step], Any]:
    """Return a controller that needs no measurement, with its default options.

    Parameters
    ----------
    name : str
        ``"spin"``, ``"drive-around"``, ``"pseudo-random-binary"``, ``"multi-sine"`` or ``"chirp"``.
    """
    return _NAMES[check_choice("control", name, tuple(_NAMES))]()
