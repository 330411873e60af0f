"""The table of what stops the robot: each row names tests that exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "python/robsim/lab/ARCHITECTURE.md"


@pytest.mark.skipif(not PAGE.is_file(), reason="needs the sources")
def test_each_stop_is_shown_by_tests_that_exist():
    table = PAGE.read_text(encoding="utf-8").split("## Stops")[1].split("\n## ")[0]
    rows = [row.split("|") for row in table.splitlines() if row.startswith("|")][2:]
    assert len(rows) > 10
    names = r"^def (test_\w+)|^TEST\(\w+, (\w+)\)"
    files = [*(ROOT / "tests").rglob("test_*.py"), *(ROOT / "tests/core").glob("*.cpp")]
    texts = [file.read_text(encoding="utf-8") for file in files]
    there = {a or b for text in texts for a, b in re.findall(names, text, re.MULTILINE)}
    for row in rows:
        shown = re.findall(r"`(\w+)`", row[5])
        assert shown
        assert set(shown) <= there
