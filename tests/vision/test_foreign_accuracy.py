"""How the measurement is judged in frames drawn by other code."""

import re
from dataclasses import dataclass

import numpy as np
import pytest

import foreign_accuracy
import foreign_false_poses
from foreign_accuracy import Errors, compared, counted, worse
from foreign_frames import CASES, NARROW, VIEWS, Case


def errors_of(spread, count=80, *, missed=(), false=()):
    rng = np.random.default_rng(3)
    poses = rng.normal(0, spread, (count, 3)) * (1, 1, 0.02)
    poses[list(missed)] = np.nan
    poses[list(false)] = 50
    return Errors(poses, np.full(count, 3.0))


def test_worse_is_what_exceeds_the_spread():
    old = errors_of(0.1)
    assert worse(old, old) == []
    assert worse(errors_of(0.05), old) == []
    assert worse(errors_of(0.102), old) == []
    assert worse(errors_of(0.12), old) == ["place", "heading"]
    assert worse(errors_of(0.1, missed=range(3)), old) == []
    assert worse(errors_of(0.1, missed=range(12)), old) == ["misses"]
    assert worse(errors_of(0.1, false=range(12)), old) == ["false poses"]
    assert worse(old, errors_of(0.1, missed=range(12))) == []


def test_rates_of_errors():
    errors = errors_of(0.1, missed=range(4), false=(5, 6))
    assert (np.sum(~errors.found), errors.false.sum(), errors.good.sum()) == (4, 2, 74)
    assert errors.nees == 1
    assert errors.rms()[0] == pytest.approx(0.1 * np.sqrt(2), rel=0.2)
    nothing = errors_of(0.1, count=2, missed=(0, 1))
    assert np.isnan([*nothing.rms(), nothing.nees]).all()
    assert foreign_accuracy.row(nothing).split() == ["-", "-", "2", "0"]


@dataclass
class WithCovariance:
    """A measurement that says how good it is."""

    pose: np.ndarray
    covariance: np.ndarray


@dataclass
class WithSignal:
    """A measurement that says how far it stands out of the noise."""

    pose: np.ndarray
    signal_to_noise: float


@pytest.mark.long
@pytest.mark.parametrize(("ways", "status"), [("same", 0), ("noisier", 1)])
def test_the_script_fails_where_the_fit_is_worse(monkeypatch, capsys, ways, status):
    def fitted(frame, markers):
        if (found := counted(frame, markers)) is None:
            return None
        off = (1.0, -1.0, 0.0) if ways == "noisier" else (0.0, 0.0, 0.0)
        return WithCovariance(found.pose + off, np.eye(3))

    monkeypatch.setitem(foreign_accuracy.WAYS, "fitted", fitted)
    monkeypatch.setattr(foreign_accuracy, "VIEWS", NARROW)
    assert foreign_accuracy.main(["--frames", "4", "--cases", "clean", "tilted"]) == status
    printed = capsys.readouterr().out
    assert ("clean, markers of 20.9 px: place" in printed) == (status == 1)
    assert len(re.findall(r"\n(clean|tilted) .* 0    0 .* 0    0", printed)) == 4


@pytest.mark.long
def test_the_hsv_threshold_finds_the_markers_in_dim_light():
    pytest.importorskip("cv2")
    for view in NARROW.values():
        found = compared("exposure 0.2", view, 4, {"hsv": foreign_accuracy.hsv})["hsv"]
        assert found.good.all()
        assert found.rms()[0] < 0.3


#: Of the blobs' centroids: rms in px of the work area, at most, for both sizes of markers.
COUNTED = {
    "clean": (0.09, 0.22),
    "JPEG 75": (0.13, 0.42),
    "Gaussian 20 %": (0.28, 0.70),
    "tilted": (0.22, 0.35),
    "other markers": (0.12, 0.30),
}


@pytest.mark.long
@pytest.mark.parametrize("name", COUNTED)
def test_the_blobs_are_where_the_robot_is(name):
    if CASES[name].jpeg:
        pytest.importorskip("cv2")
    # in a narrow view a tilted camera would stand close to the floor
    views = VIEWS if CASES[name].tilted else NARROW
    for view, limit in zip(views.values(), COUNTED[name], strict=True):
        found = compared(name, view, 6, {"counted": counted})["counted"]
        assert found.good.all()
        assert found.rms()[0] < limit


def test_poses_on_an_empty_floor_are_false():
    def always(frame, markers):
        return WithSignal(np.array((100.0, 90.0, 0.0)), 2.5)

    view, case = NARROW["10.5 px"], Case()
    errors, signals = foreign_false_poses.reported(case, view, 2, always, empty=True)
    assert np.isinf(errors).all()
    assert (signals == 2.5).all()
    assert foreign_false_poses.row(case, view, 2, always).split()[:2] == ["2", "0"]
    assert foreign_false_poses.row(case, view, 2, counted).split()[:3] == ["0", "0", "0"]
