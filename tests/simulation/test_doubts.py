"""Results that callbacks can hardly mean: a run warns of each kind once, with slot and step."""

import math
import warnings

import numpy as np
import pytest

import robsim


def located(step):
    return robsim.locate(step.blobs, step.markers, image=step.frame, colors=step.colors)


def in_degrees(step):
    seen = located(step)
    return seen and (*seen.pose[:2], math.degrees(seen.pose[2]))


def measured_in_degrees(step):
    seen = located(step)
    return seen and robsim.Measurement(in_degrees(step))


class Unwrapped:
    """Counts the turns on."""

    heading = 0.0

    def __call__(self, step):
        if (seen := located(step)) is None:
            return None
        self.heading += robsim.wrap_angle(seen.pose[2] - self.heading)
        return (*seen.pose[:2], self.heading)


def within_a_turn(step):
    seen = located(step)
    return seen and (*seen.pose[:2], seen.pose[2] % (2 * math.pi))


def warnings_of(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    assert all(one.filename == __file__ for one in caught)
    return [str(one.message) for one in caught]


def test_no_warning_takes_the_place_of_an_error():
    def control(step):
        return 1 / (40 - step.k), 0.0

    sim = robsim.Simulation(measure=in_degrees, control=control, start=(600, 600, 0.5), seed=1)
    assert warnings_of(lambda: sim.run(39))  # with the default it would be an error here
    sim.reset()
    with pytest.raises(ZeroDivisionError):
        sim.run(60)


@pytest.mark.long
@pytest.mark.parametrize("control", [robsim.Spin(1.0), robsim.DriveAround()])
@pytest.mark.parametrize(
    ("measure", "told"),
    [(in_degrees, 1), (measured_in_degrees, 1), (located, 0), (Unwrapped, 0), (within_a_turn, 0)],
)
def test_a_heading_in_degrees_is_told_once(measure, told, control):
    sim = robsim.Simulation(
        measure=Unwrapped() if measure is Unwrapped else measure,
        control=control,
        dropout=robsim.Dropout(0.1),
        resolution=(400, 400),
        seed=3,
    )
    found = warnings_of(lambda: [sim.run(150), sim.run(150)])
    assert len(found) == told
    assert all("measure" in text and "degrees" in text for text in found)


def estimating(covariance):
    return robsim.Simulation(
        estimate_state=lambda step: robsim.Estimate(
            (0, 0, 0), covariance if step.k >= 4 else np.eye(3)
        )
    )


@pytest.mark.parametrize(
    ("entries", "fault"),
    [
        ({(0, 1): 0.5}, "not symmetric: C[0, 1] = 0.5, but C[1, 0] = 0"),
        ({(0, 2): 1.5, (2, 0): 1.5}, "not positive"),
        (
            {(i, j): -0.9 for i in range(3) for j in range(3) if i != j},
            "not positive",
        ),
        ({(0, 1): 1e-3}, None),  # rounding of a filter that began with a large covariance
        ({(0, 1): 1.0, (1, 0): 1.0}, None),
        ({(i, i): 0.0 for i in range(3)}, None),
    ],
)
def test_a_covariance_that_is_none_is_told_at_its_step(entries, fault):
    covariance = np.eye(3)
    for at, value in entries.items():
        covariance[at] = value
    sim = estimating(covariance)
    found = warnings_of(lambda: [sim.step() for _ in range(8)])
    if fault is None:
        assert found == []
    else:
        (text,) = found
        assert text.startswith("step 4: ")
        assert "estimate_state" in text
        assert fault in text


def test_a_run_that_fails_is_warned_of_and_so_is_the_next_one():
    def fails(step):
        if step.k == 3:
            raise ArithmeticError("as the covariance cannot be inverted")
        return (1e6, 0)

    sim = robsim.Simulation(control=fails, boundary="unlimited")
    for _ in range(2):
        with pytest.raises(ArithmeticError), pytest.warns(UserWarning, match=r"step 0: .*1000000"):
            sim.run(10)
        sim.reset()


def test_usual_voltages_are_not_told():
    assert warnings_of(robsim.Simulation(control=lambda step: (24, -24)).step) == []


@pytest.mark.parametrize("noise", [robsim.GaussianNoise, robsim.UniformNoise])
def test_a_noise_below_a_percent_is_told(noise):
    (text,) = warnings_of(lambda: noise(0.2))
    assert f"{noise.__name__}(20)" in text
    assert warnings_of(lambda: [noise(0), noise(1), noise(20)]) == []


def test_a_campaign_tells_it_in_its_first_run_alone():
    def run():
        vary = {"control": {"strong": lambda step: (1e6, 1e6)}}
        robsim.campaign(robsim.Scenario(), runs=3, steps=2, vary=vary, metrics=len, seed=1)

    assert len(warnings_of(run)) == 1
