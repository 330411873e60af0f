"""The benchmark runs and says what it found; how fast it is no test asks."""

import json
import re

import numpy as np
import pytest

from commands import command
from robsim._core import cpu_path
from robsim.bench import BenchResult, Case, run_bench
from robsim.bench import _vision as vision
from robsim.bench._cases import timed

pytest.importorskip("cv2")


@pytest.mark.slow
@pytest.mark.usefixtures("small_bench")
def test_the_command_prints_numbers_for_scripts(tmp_path):
    run = command("bench", "--rounds", "1", "--json", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    numbers = json.loads(run.stdout)
    assert numbers["cpu_path"] == cpu_path()
    assert numbers["cases"]["detect_gaussian_480"]["opencv_ratio"] > 0


@pytest.mark.long
def test_all_cases_have_numbers():
    result = run_bench(rounds=1, sizes=(480,), frames=3, steps=20)
    cases = result.to_dict()["cases"]

    def compared(name):
        return {key for key, value in cases[name].items() if value is not None} - {"ours", "unit"}

    detect = cases["detect_clean_480"]
    opencv, components = ({f"{who}", f"{who}_ratio"} for who in ("opencv", "components"))
    numpy = {"numpy", "numpy_ratio"}
    assert compared("detect_clean_480") == opencv | components | {"memory_read"}
    assert detect["opencv_ratio"] == pytest.approx(detect["opencv"] / detect["ours"])
    for kind in ("gaussian", "uniform"):
        assert compared(f"noise_{kind}_480") == opencv | numpy
        for name in (f"detect_{kind}_480", f"detect_{kind}_raw_480"):
            assert cases[name]["components_ratio"] > 0
    for name in ("render_480", "step_gaussian_480"):
        assert compared(name) == opencv
    for name in ("recursive_update", "batch_10000x5", "new_run_100", "reset_run_100"):
        assert compared(name) == numpy
    assert cases["recursive_update"]["unit"] == "ns"
    assert list(result.to_dict()["rates"]) == [
        *("tracking_smoothing_off", "tracking_default"),
        *("loop_native", "loop_controller", "loop_five_callbacks"),
    ]
    assert all(name in str(result) for name in cases)


def test_the_table():
    case = Case(name="detect_1", ours=2.0, others={"opencv": 9.0, "memory_read": 0.5})
    text = str(BenchResult(cpu_path="avx2", cases=(case,), rates={"loop": 1234567.8}))
    assert "detect_1" in text
    assert re.search(r"2 +9 +4\.5 +0\.5$", text, re.MULTILINE)
    assert "1,234,568" in text


def test_medians_are_taken_in_turns():
    order = []
    calls = {"ours": lambda: order.append("a"), "numpy": lambda: order.append("b")}
    case = timed("some", calls, 3, unit="us", repeats=10)
    assert "".join(order) == "ab" * 5  # two rounds to warm up
    assert case.ours >= 0
    assert (case.unit, set(case.others)) == ("us", {"numpy"})


def test_blobs_that_differ_are_no_comparison(monkeypatch):
    monkeypatch.setattr(vision, "find_blobs", lambda *_, **__: {"red": [], "blue": []})
    with pytest.raises(RuntimeError, match="same red"):
        run_bench(rounds=1, sizes=(480,))


def test_both_find_the_same_blobs_in_strong_noise():
    import cv2

    shown = vision.scene("gaussian", 480)
    assert (shown.smoothing, shown.minimum_area) == (3, 11)
    calls = vision.detect_calls(cv2, shown)
    ours = max(calls["ours"]()["red"], key=lambda blob: blob.area)
    for name in ("opencv", "components"):
        found = calls[name]()["red"]
        area, *place = found[np.argmax(found[:, 0])]
        assert area == pytest.approx(ours.area, rel=0.2)
        np.testing.assert_allclose(place, ours.centroid, atol=1)
