"""The benchmark runs and says what it found; how fast it is no test asks."""

import json

import pytest

from commands import cli
from robsim import bench

pytest.importorskip("cv2")


def test_the_command_prints_numbers_for_scripts(tmp_path):
    run = cli("bench", "--rounds", "1", "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    numbers = json.loads(run.stdout)
    assert numbers["cpu_path"] in ("baseline", "avx2")
    assert numbers["frames_per_second"] > 0
    for size in (1200, 480):
        detect = numbers[f"detect_clean_{size}"]
        assert set(detect) == {"ours_ms", "opencv_ms", "ratio", "memory_read_ms"}
        assert detect["ratio"] == pytest.approx(detect["opencv_ms"] / detect["ours_ms"])
        for kind in ("gaussian", "uniform"):
            noise = numbers[f"noise_{kind}_{size}"]
            assert set(noise) == {"ours_ms", "opencv_ms", "ratio", "numpy_ms", "numpy_ratio"}


def test_the_table():
    case = bench.Case(name="detect_1", ours_ms=2.0, others_ms={"opencv": 9.0, "memory_read": 0.5})
    text = str(bench.BenchResult(cpu_path="avx2", cases=(case,), frames_per_second=1234.4))
    assert "detect_1" in text
    assert "9.000 (4.50 x)" in text
    assert "1234 frames" in text


def test_blobs_that_differ_are_no_comparison(monkeypatch):
    monkeypatch.setattr(bench, "find_blobs", lambda *_, **__: {"red": [], "blue": []})
    with pytest.raises(RuntimeError, match="must find the same red blobs"):
        bench.run_bench(rounds=1)
