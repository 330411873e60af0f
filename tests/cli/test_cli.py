"""``robsim demo``, and what all commands have in common."""

import json

import numpy as np
import pytest
from PIL import Image

import robsim
from commands import command

pytestmark = [pytest.mark.kernels, pytest.mark.long]

FIGURES = ["camera.jpg", "traces.png", "parameters.png", "batch.png"]


def test_the_demo_writes_what_it_found_and_its_numbers_are_right(tmp_path):
    run = command("demo", "--json", "--out", "made/here", "--seed", "3", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    folder = tmp_path / "made/here"
    assert {file.name for file in folder.iterdir()} == {*FIGURES, "trace.npz"}
    for name in FIGURES:
        with Image.open(folder / name) as picture:
            assert min(picture.size) > 500
    trace = robsim.Trace.load(folder / "trace.npz")
    assert len(trace) == 1000
    assert trace.info.identify_from == "measurement"
    assert np.ptp(trace.pose_true[:, :2], axis=0).max() > 300  # it drives
    assert trace.noise.any()

    numbers = json.loads(run.stdout)
    parameters = numbers["batch_estimate"]["parameters"]
    assert list(parameters) == list(robsim.trace.PARAMETER_NAMES)
    for name, values in parameters.items():
        if not name.startswith("d1"):
            batch, online = (abs(values[key] / values["true"] - 1) for key in ("batch", "online"))
            assert batch < 0.005  # without bias, though the poses are noisy
            assert batch < online < 0.5
            assert abs(values["batch"] - values["true"]) < 4 * values["standard_error"]
    error = trace.error[trace.seen]
    tracking = numbers["tracking"]
    assert tracking["units"]["rmse_xy"] == "px"
    assert (tracking["steps"], tracking["seen"]) == (1000, trace.seen.sum())
    assert tracking["false_poses"] == 0
    assert tracking["seen"] > 990
    assert tracking["rmse_xy"] == pytest.approx(np.sqrt((error[:, :2] ** 2).sum(axis=1).mean()))
    assert tracking["rmse_xy"] < 0.6
    assert tracking["rmse_heading_deg"] < 0.6


def test_the_version():
    assert command("--version").stdout == f"robsim {robsim.__version__}\n"
