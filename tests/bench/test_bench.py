"""The benchmark runs and says what it found; how fast it is no test asks."""

import json

import numpy as np
import pytest

from commands import cli
from robsim.bench import BenchResult, Case, run_bench
from robsim.bench import _vision as vision
from robsim.bench._cases import timed

pytest.importorskip("cv2")


@pytest.mark.slow
def test_the_command_prints_numbers_for_scripts(tmp_path):
    run = cli("bench", "--rounds", "1", "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    numbers = json.loads(run.stdout)
    assert numbers["cpu_path"] in ("baseline", "avx2")
    assert numbers["detect_gaussian_1200"]["ratio"] > 0


@pytest.mark.long
def test_all_cases_have_numbers():
    result = run_bench(rounds=1, sizes=(480,), frames=3, steps=20)
    numbers = result.to_dict()
    detect = numbers["detect_clean_480"]
    assert set(detect) == {
        *("ours_ms", "opencv_ms", "ratio", "components_ms", "components_ratio", "memory_read_ms")
    }
    assert detect["ratio"] == pytest.approx(detect["opencv_ms"] / detect["ours_ms"])
    for kind in ("gaussian", "uniform"):
        noise = numbers[f"noise_{kind}_480"]
        assert set(noise) == {"ours_ms", "opencv_ms", "ratio", "numpy_ms", "numpy_ratio"}
        for name in (f"detect_{kind}_480", f"detect_{kind}_raw_480"):
            assert numbers[name]["components_ratio"] > 0
    for name in ("render_480", "step_gaussian_480"):
        assert set(numbers[name]) == {"ours_ms", "opencv_ms", "ratio"}
    assert set(numbers["recursive_update"]) == {"ours_ns", "numpy_ns", "ratio"}
    for name in ("batch_10000x5", "new_run_100", "reset_run_100"):
        assert set(numbers[name]) == {"ours_us", "numpy_us", "ratio"}
    rates = [name for name, value in numbers.items() if "steps_per_second" in value]
    assert rates == [
        *("tracking_smoothing_off", "tracking_default"),
        *("loop_native", "loop_controller", "loop_five_callbacks"),
    ]
    table = str(result)
    assert all(name in table for name in numbers if name != "cpu_path")
    assert max(map(len, table.splitlines())) <= 120


def test_the_table():
    case = Case(name="detect_1", ours=2.0, others={"opencv": 9.0, "memory_read": 0.5})
    text = str(BenchResult(cpu_path="avx2", cases=(case,), rates={"loop": 1234567.8}))
    assert "detect_1" in text
    assert "9.000 (4.5 x)" in text
    assert "1,234,568" in text


def test_medians_are_taken_in_turns():
    order = []
    calls = {"ours": lambda: order.append("a"), "numpy": lambda: order.append("b")}
    case = timed("some", calls, 3, unit="us", repeats=10)
    assert "".join(order) == "ab" * 5  # two rounds to warm up
    assert 0 <= case.ours < 1000
    assert set(case.to_dict()) == {"ours_us", "numpy_us", "ratio"}


def test_blobs_that_differ_are_no_comparison(monkeypatch):
    monkeypatch.setattr(vision, "find_blobs", lambda *_, **__: {"red": [], "blue": []})
    with pytest.raises(RuntimeError, match=r"robsim and OpenCV \(opencv\) must find the same red"):
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
