"""The table of the command: what it compares does the same; how fast it is no test asks."""

import json

import numpy as np
import pytest

from commands import command
from robsim.cli.simulated import bench as bench_table

cv2 = pytest.importorskip("cv2")

#: What each case is compared with.
COMPARED = {
    "detect_clean_480": {"opencv"},
    "detect_gaussian_480": {"opencv"},
    "noise_gaussian_480": {"opencv", "numpy"},
    "render_480": {"opencv"},
    "step_gaussian_480": {"opencv"},
    "step_tracked": set(),
    "step_unseen": {"numpy"},
    "step_controller": set(),
}


@pytest.mark.long
@pytest.mark.usefixtures("small_bench")
def test_the_command_prints_numbers_for_scripts(tmp_path):
    run = command("bench", "--rounds", "1", "--json", cwd=tmp_path)
    assert run.exit_code == 0, run.stderr
    cases = json.loads(run.stdout)["cases"]
    assert [*cases] == [*COMPARED]
    for name, case in cases.items():
        assert {other for other in ("opencv", "numpy") if case[other] is not None} == COMPARED[name]
        for other in COMPARED[name]:
            assert case[f"{other}_ratio"] == pytest.approx(case[other] / case["ours"])


def test_medians_are_taken_in_turns():
    order = []
    calls = {"ours": lambda: order.append("a"), "numpy": lambda: order.append("b")}
    assert set(bench_table.timed(calls, 3)) == {"ours", "numpy"}
    assert "".join(order) == "ab" * 5  # two rounds to warm up


def test_both_find_the_same_blobs_in_strong_noise():
    noisy = bench_table.seen_robot(480, bench_table.NOISE)
    calls = bench_table.detect_calls(cv2, noisy)
    ours = max(calls["ours"]()["red"], key=lambda blob: blob.area)
    found = calls["opencv"]()["red"]
    area, *place = found[np.argmax(found[:, 0])]
    assert area == pytest.approx(ours.area, rel=0.2)
    np.testing.assert_allclose(place, ours.centroid, atol=1)


def test_other_blobs_are_refused():
    noisy = bench_table.seen_robot(480, bench_table.NOISE)
    ours = bench_table.detect_calls(cv2, noisy)["ours"]()
    none = {color: np.empty((0, 3)) for color in ours}
    with pytest.raises(RuntimeError, match="OpenCV must find the"):
        bench_table.check_same_blobs(ours, none)


@pytest.mark.long
def test_both_draw_the_same_moving_robot():
    calls = bench_table.render_calls(cv2, 480)
    ours, theirs = ([calls[n]().astype(int).copy() for _ in range(2)] for n in ("ours", "opencv"))
    for mine, other in zip(ours, theirs, strict=True):
        assert np.abs(mine - other).max() <= bench_table.MAXIMUM_DIFFERENCE
    assert np.abs(ours[0] - ours[1]).max() > 50


def test_both_go_the_same_way_without_frames():
    calls = bench_table.unseen_calls(60)
    calls["ours"]()
    assert calls["numpy"]().shape == (60, 3)
