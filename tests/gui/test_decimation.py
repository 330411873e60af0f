"""The arithmetic of the charts in the browser, run by node: extremes by blocks, ticks, texts."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import robsim.gui

pytestmark = pytest.mark.long

N = 5_011
OUTLIER = 2_345


@pytest.fixture(scope="module")
def run_node():
    """Return a function that runs a module of the charts, then code, whose result it returns."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node")

    def run(module, code, data=None):
        source = (Path(robsim.gui.__file__).parent / "static/charts" / module).read_text("utf-8")
        values = json.dumps(data)
        program = (
            f"{source}\nconst data = {values};\nconsole.log(JSON.stringify((() => {{{code}}})()));"
        )
        command = [node, "--input-type=module"]
        done = subprocess.run(command, input=program, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="module")
def numbers():
    """Return a random walk with gaps and a single outlier."""
    rng = np.random.default_rng(16)
    values = np.cumsum(rng.normal(size=N))
    values[rng.random(N) < 0.1] = np.nan
    values[3000:3400] = np.nan
    values[OUTLIER] = 1e6
    return values


FILL = """
const extremes = new Extremes();
const value = (row) => data.values[row] ?? NaN;
for (const count of data.counts) extremes.extend(count, value);
"""


def test_blocks_have_the_extremes_of_their_rows_however_they_came(run_node, numbers):
    values = [None if np.isnan(value) else value for value in numbers.tolist()]
    counts = [1, 7, 8, 9, 100, 101, 2048, 2049, 4000, N]
    code = FILL + (
        "return extremes.levels.map((_, level) => { const blocks = [];"
        "extremes.visit(0, data.values.length, 8 * 4 ** level, (...block) => blocks.push(block));"
        "return blocks; });"
    )
    levels = run_node("decimate.js", code, {"values": values, "counts": counts})
    assert len(levels) == 6
    for level, blocks in enumerate(levels):
        size = 8 * 4**level
        known = [k for k in range(0, N, size) if np.isfinite(numbers[k : k + size]).any()]
        assert [row for row, _, _ in blocks] == known
        for row, low, high in blocks:
            rows = numbers[row : row + size]
            assert (low, high) == (np.nanmin(rows), np.nanmax(rows))


def test_numbers_are_written_as_in_a_paper(run_node):
    expected = {
        "tickText(1.9, 0.05)": "1.90",
        "tickText(-0.5, 0.5)": "\u22120.5",
        "tickText(1e-17, 0.1)": "0",
        "tickText(8.4e-6, 2e-7)": "8.4e\u22126",
        "numberText(8.3333e-6)": "8.333e\u22126",
        "numberText(-600.126)": "\u2212600.1",
        "numberText(NaN)": "\u2013",
        "uncertainText(1.93751, 0.0123)": "1.938 \u00b1 0.012",
        "uncertainText(600.2, 12)": "600 \u00b1 12",
        "uncertainText(8.3333e-6, 3e-7)": "8.33e\u22126 \u00b1 3e\u22127",
        "uncertainText(5, NaN)": "5.000",
    }
    found = run_node("scale.js", f"return [{','.join(expected)}];")
    assert dict(zip(expected, found, strict=True)) == expected
