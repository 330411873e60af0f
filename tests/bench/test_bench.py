"""The benchmark runs and says what it found; how fast it is no test asks."""

import json

import numpy as np
import pytest

from commands import command
from robsim.bench import _cases as cases
from robsim.bench import _render as render
from robsim.bench import _vision as vision

cv2 = pytest.importorskip("cv2")

#: What each case is compared with.
COMPARED = {
    "detect_clean_480": {"opencv", "components", "memory_read"},
    "noise_gaussian_480": {"opencv", "numpy"},
    "detect_gaussian_raw_480": {"opencv", "components"},
    "render_480": {"opencv"},
    "step_gaussian_480": {"opencv"},
    "recursive_update": {"numpy"},
    "batch_10000x5": {"numpy"},
    "reset_run_100": {"numpy"},
}


@pytest.mark.slow
@pytest.mark.usefixtures("small_bench")
def test_the_command_prints_numbers_for_scripts(tmp_path):
    run = command("bench", "--rounds", "1", "--json", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    numbers = json.loads(run.stdout)
    for name, others in COMPARED.items():
        case = numbers["cases"][name]
        others_of_all = set.union(*COMPARED.values())
        assert {other for other in others_of_all if case.get(other) is not None} == others
        for other in others - {"memory_read"}:
            assert case[f"{other}_ratio"] == pytest.approx(case[other] / case["ours"])
    assert list(numbers["rates"]) == [
        *("tracking_smoothing_off", "tracking_default"),
        *("loop_native", "loop_controller", "loop_five_callbacks"),
    ]


def test_medians_are_taken_in_turns():
    order = []
    calls = {"ours": lambda: order.append("a"), "numpy": lambda: order.append("b")}
    case = cases.timed("some", calls, 3, unit="us", repeats=10)
    assert "".join(order) == "ab" * 5  # two rounds to warm up
    assert (case.unit, set(case.others)) == ("us", {"numpy"})


def test_both_find_the_same_blobs_in_strong_noise():
    calls = vision.detect_calls(cv2, vision.scene("gaussian", 480))
    ours = max(calls["ours"]()["red"], key=lambda blob: blob.area)
    for name in ("opencv", "components"):
        found = calls[name]()["red"]
        area, *place = found[np.argmax(found[:, 0])]
        assert area == pytest.approx(ours.area, rel=0.2)
        np.testing.assert_allclose(place, ours.centroid, atol=1)


@pytest.mark.long
def test_both_draw_the_same_moving_robot():
    calls = render.render_calls(cv2, 480)
    ours, theirs = ([calls[n]().astype(int).copy() for _ in range(2)] for n in ("ours", "opencv"))
    for mine, other in zip(ours, theirs, strict=True):
        assert np.abs(mine - other).max() <= render.MAXIMUM_DIFFERENCE
    assert np.abs(ours[0] - ours[1]).max() > 50
