"""`robsim run --scenario`."""

import numpy as np
import pytest

import robsim
from commands import command


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_a_scenario_is_run_and_options_change_it(tmp_path):
    scenario = robsim.Scenario(
        measure=True,
        control=robsim.DriveAround(),
        resolution=(240, 240),
        headings=None,
        noise=robsim.GaussianNoise(5),
        process_noise=robsim.WheelNoise(0.05),
        seed=3,
    )
    scenario.save(tmp_path / "noisy.toml")
    for options, expected in {
        (): scenario,
        ("--noise", "uniform:3", "--headings", "36", "--seed", "4"): scenario.replace(
            noise=robsim.UniformNoise(3), headings=36, seed=4
        ),
    }.items():
        run = command("run", "--scenario", "noisy.toml", "--steps", "6", *options, cwd=tmp_path)
        assert run.exit_code == 0, run.stderr
        trace = robsim.Trace.load(tmp_path / "robsim-run" / "trace.npz")
        assert robsim.Scenario.of(trace) == expected
        again = robsim.Simulation(expected).run(6)
        np.testing.assert_array_equal(again.pose_measured, trace.pose_measured)


def test_a_scenario_with_a_mistake_is_named(tmp_path):
    (tmp_path / "wrong.toml").write_text("format = 1\nnoize = 3\n")
    run = command("run", "--scenario", "wrong.toml", cwd=tmp_path)
    assert run.exit_code == 2
    assert "wrong.toml" in run.stderr.replace("\n", "")
    assert "did you mean" in run.stderr.replace("\n", " ")
