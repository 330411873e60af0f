"""Controllers without feedback: excitation and replay."""

from dataclasses import FrozenInstanceError, replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from commands import command
from robsim import DriveAround, Replay, Simulation
from robsim.control import Chirp, MultiSine, PseudoRandomBinary
from sizes import thorough

# --- excitation


DT = 0.2
KINDS = [PseudoRandomBinary, MultiSine, Chirp]


def voltages(control, steps, *, dt=DT):
    """Return the voltages of steps 0, 1, ...: array (steps, 2)."""
    return np.array([control(SimpleNamespace(k=k, t=k * dt, dt=dt)) for k in range(steps)])


def autocorrelation(x, y):
    """Return the mean of x(i) y(i + shift) over a period, for every shift."""
    return np.array([np.mean(x * np.roll(y, -shift)) for shift in range(len(x))])


# --- pseudo-random binary sequences


@pytest.mark.kernels
@pytest.mark.long
@pytest.mark.parametrize("order", thorough(range(3, 13), (3, 6, 9, 12)))
def test_a_sequence_is_balanced_and_of_maximum_length(order):
    length = 2**order - 1
    control = PseudoRandomBinary(low=0, high=1, hold=1, order=order)
    assert control.period == length
    bits = voltages(control, 2 * length)
    np.testing.assert_array_equal(bits[:length], bits[length:])
    for motor in bits[:length].T:
        assert motor.sum() == 2 ** (order - 1)
        # Every window of `order` bits but 0 .. 0 comes once: there is no shorter period.
        windows = np.lib.stride_tricks.sliding_window_view(np.append(motor, motor), order)
        assert len(np.unique(windows[:length], axis=0)) == length


@pytest.mark.kernels
@pytest.mark.parametrize("seed", [0, 5])
def test_a_sequence_looks_like_white_noise(seed):
    control = PseudoRandomBinary(low=-1, high=1, hold=1, order=7, seed=seed)
    left, right = voltages(control, 127).T
    for motor in (left, right):
        correlation = autocorrelation(motor, motor)
        assert correlation[0] == 1
        np.testing.assert_allclose(correlation[1:], -1 / 127)
    between = autocorrelation(left, right)
    assert np.flatnonzero(between > 0).tolist() == [127 - 63]
    assert between[0] == pytest.approx(-1 / 127)


@pytest.mark.kernels
def test_a_voltage_is_held():
    fast = voltages(PseudoRandomBinary(hold=1, order=5), 31)
    held = voltages(PseudoRandomBinary(hold=4, order=5), 4 * 31)
    np.testing.assert_array_equal(held, np.repeat(fast, 4, axis=0))


# --- sums of sines


def crest_factor(signal):
    return np.abs(signal).max() / np.sqrt(np.mean(signal**2))


@pytest.mark.kernels
def test_the_sines_are_where_they_should_be_and_nowhere_else():
    control = MultiSine(low=-1, high=1, minimum_frequency=0.0125, maximum_frequency=0.4)
    left, right = control.frequencies
    np.testing.assert_allclose(left, 0.0125 * np.arange(1, 33, 2))
    np.testing.assert_allclose(right, 0.0125 * np.arange(2, 33, 2))
    period = 400
    u = voltages(control, period)
    spectrum = np.abs(np.fft.rfft(u, axis=0)) / (period / 2)
    frequencies = np.fft.rfftfreq(period, DT)
    for motor, lines in zip(spectrum.T, (left, right), strict=True):
        found = np.flatnonzero(motor > 1e-9)
        np.testing.assert_allclose(frequencies[found], lines, atol=1e-12)
        np.testing.assert_allclose(motor[found], motor[found[0]])
    assert abs(np.mean(u[:, 0] * u[:, 1])) < 1e-12


@pytest.mark.kernels
@pytest.mark.long
@pytest.mark.parametrize("highest", thorough((0.1, 0.3, 1.0), (0.1, 1.0)))
def test_the_peaks_are_low(highest):
    control = MultiSine(low=-1, high=1, maximum_frequency=highest, seed=3)
    fine = voltages(control, 8000, dt=80 / 8000)
    for motor, lines in zip(fine.T, control.frequencies, strict=True):
        zero_phases = np.cos(2 * np.pi * np.outer(np.arange(8000) / 100, lines)).sum(axis=1)
        assert crest_factor(zero_phases) == pytest.approx(np.sqrt(2 * len(lines)))
        assert crest_factor(motor) < 2.05
        # the limits are used
        assert 0.99 < np.abs(motor).max() < 1


@pytest.mark.kernels
def test_the_sines_repeat_after_a_period():
    u = voltages(MultiSine(seed=2), 800)
    np.testing.assert_allclose(u[400:], u[:400], atol=1e-12)


# --- swept sines


@pytest.mark.kernels
@pytest.mark.long
def test_the_frequency_of_a_chirp_is_what_it_says():
    control = Chirp(low=-1, high=1, minimum_frequency=0.02, maximum_frequency=0.5, duration=80)
    assert control.frequencies(0) == pytest.approx((0.02, 0.5))
    assert control.frequencies(40) == pytest.approx((0.1, 0.1))
    assert control.frequencies(80 - 1e-9) == pytest.approx((0.5, 0.02))
    dt = 0.004
    t = dt * np.arange(20_000)
    for motor, u in enumerate(voltages(control, len(t), dt=dt).T):
        # Between two crossings of zero a sine does half a turn.
        before = np.flatnonzero(u[1:] * u[:-1] < 0)
        crossings = t[before] + dt * u[before] / (u[before] - u[before + 1])
        turned = [
            (end - begin) * np.mean([control.frequencies(x)[motor] for x in inside])
            for begin, end in pairwise(crossings)
            for inside in [begin + (end - begin) * (np.arange(50) + 0.5) / 50]
        ]
        assert len(turned) > 20
        np.testing.assert_allclose(turned, 0.5, atol=1e-3)


@pytest.mark.kernels
def test_a_chirp_starts_anew_after_its_duration():
    u = voltages(Chirp(duration=20), 300)
    np.testing.assert_allclose(u[100:200], u[:100], atol=1e-9)
    np.testing.assert_allclose(u[200:], u[:100], atol=1e-9)


# --- all of them


@pytest.mark.kernels
@pytest.mark.parametrize("kind", KINDS)
def test_the_limits_are_kept_and_reached(kind):
    for low, high in ((-0.5, 1.5), (-3, -1)):
        u = voltages(kind(low=low, high=high), 800)
        assert u.min() >= low
        assert u.max() <= high
        middle, reach = (high + low) / 2, (high - low) / 2
        assert (np.abs(u - middle).max(axis=0) > 0.95 * reach).all()


@pytest.mark.kernels
@pytest.mark.parametrize("kind", [PseudoRandomBinary, MultiSine])
def test_the_seed_decides(kind):
    first = voltages(kind(seed=7), 200)
    np.testing.assert_array_equal(voltages(kind(seed=7), 200), first)
    assert (voltages(kind(seed=8), 200) != first).any()


@pytest.mark.kernels
@pytest.mark.parametrize("kind", KINDS)
def test_a_step_says_it_all(kind):
    """One object serves any number of runs, at any step."""
    control = kind()
    u = voltages(control, 50)
    step = SimpleNamespace(k=31, t=31 * DT, dt=DT)
    np.testing.assert_array_equal(control(step), u[31])
    np.testing.assert_array_equal(kind()(step), u[31])
    assert control == kind()
    assert control != replace(control, high=2.0)
    with pytest.raises(FrozenInstanceError):
        control.high = 2.0


@pytest.mark.kernels
@pytest.mark.parametrize("kind", KINDS)
def test_from_the_truth_each_gives_all_parameters(kind):
    options = {"boundary": "unlimited", "estimate_parameters": True, "seed": 1}
    trace = robsim.Simulation(control=kind(), **options).run(800)
    assert np.isin(trace.u, voltages(kind(), 800)).all()
    report = robsim.batch_estimate(trace)
    assert (report.rank == 5).all()
    truth = report.theta_true
    np.testing.assert_allclose(report.batch[:, :4], truth[:, :4], rtol=1e-6)
    np.testing.assert_allclose(report.batch[:, 4], truth[:, 4], atol=1e-9)


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("kind", "name", "wrong"),
    [
        (PseudoRandomBinary, "low", {"low": 1, "high": 1}),
        (MultiSine, "low", {"low": 2}),
        (Chirp, "high", {"high": np.nan}),
        (PseudoRandomBinary, "hold", {"hold": 0}),
        (PseudoRandomBinary, "order", {"order": 2}),
        (PseudoRandomBinary, "order", {"order": 13}),
        (PseudoRandomBinary, "seed", {"seed": -1}),
        (MultiSine, "seed", {"seed": -1}),
        (MultiSine, "minimum_frequency", {"minimum_frequency": 0}),
        (MultiSine, "maximum_frequency", {"minimum_frequency": 0.1, "maximum_frequency": 0.199}),
        (MultiSine, "maximum_frequency", {"minimum_frequency": 1e-3, "maximum_frequency": 1.001}),
        (Chirp, "minimum_frequency", {"minimum_frequency": 0.5, "maximum_frequency": 0.5}),
        (Chirp, "duration", {"duration": 0}),
        (robsim.DriveAround, "hold", {"hold": 0}),
        (robsim.DriveAround, "low", {"low": 2}),
        (robsim.DriveAround, "low", {"high": -1}),
        (robsim.Spin, "voltage", {"voltage": np.inf}),
    ],
)
def test_wrong_options_are_named(kind, name, wrong):
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        kind(**wrong)


@pytest.mark.kernels
@pytest.mark.parametrize("kind", [MultiSine, Chirp])
def test_a_frequency_must_be_below_half_the_sampling_frequency(kind):
    control = kind(maximum_frequency=2.5)
    with pytest.raises(ValueError, match=r"maximum_frequency.* 2.5 Hz for dt = 0.2"):
        robsim.Simulation(control=control).run(1)
    voltages(control, 3, dt=0.1)


# --- by name


@pytest.mark.kernels
@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_on_the_command_line_one_takes_the_place_of_the_folders(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/control.py").write_text("def control(step):\n    return 0.0, 0.0\n")

    def run(*options):
        done = command("run", "mine", "--steps", "20", "--control", *options, cwd=tmp_path)
        assert done.exit_code == 0, done.stderr
        return robsim.Trace.load(tmp_path / "robsim-run/trace.npz").u

    np.testing.assert_array_equal(run("multi-sine"), voltages(MultiSine(), 20))
    np.testing.assert_array_equal(run("chirp"), voltages(Chirp(), 20))


# --- replay


NAN, INF = np.nan, np.inf
U = np.arange(6.0).reshape(3, 2) / 10


def test_a_run_is_driven_once_more():
    first = Simulation(control=DriveAround(), seed=1).run(40)
    again = Simulation(control=Replay(first.u)).run(40)
    assert np.array_equal(again.u, first.u)
    assert np.array_equal(again.pose_true, first.pose_true)


def test_beyond_the_end_there_is_no_input():
    sim = Simulation(control=Replay(U))
    with pytest.raises(IndexError, match=r"3 rows.*step 3"):
        sim.run(5)
    assert np.array_equal(sim.trace.u, U)
    assert len(Simulation(control=Replay(U)).run(3)) == 3


def test_no_inputs_at_all():
    assert Replay(np.empty((0, 2))).u.shape == (0, 2)
    with pytest.raises(IndexError, match="0 rows"):
        Simulation(control=Replay(np.empty((0, 2)))).run(1)


def test_the_inputs_are_its_own_and_read_only():
    given = U.copy()
    replay = Replay(given)
    given[:] = 9
    u = replay.u
    del replay
    assert np.array_equal(u, U)
    with pytest.raises(ValueError, match="read-only"):
        u[0] = 1


def test_what_is_no_record_of_inputs():
    for wrong in ([], U.T, U[0], U[None], [(1, NAN)], [(INF, 1)]):
        with pytest.raises(ValueError, match=r"^u\b"):
            Replay(wrong)
