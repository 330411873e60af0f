"""Every statistical verdict is given as often as the documentation promises."""

import json

import pytest

from robsim.evaluation import _consistency, _whiteness
from size_and_power import Row, as_json, as_markdown, counted, family_names, measured
from size_and_power.families import nees, whiteness

# With this probability of a false alarm a row, nobody sees one.
NEVER = 1e-6

SEEDS = {"nees": 30, "nis": 60, "whiteness": 60}


@pytest.mark.slow
@pytest.mark.kernels
@pytest.mark.parametrize(
    "family", [name for name in family_names() if name != "doctor"]
)  # test_zoo
def test_the_promises_hold(family):
    rows = measured(SEEDS.get(family, 40), [family], processes=1)
    broken = [row for row in rows if row.p_value < NEVER]
    assert not broken, as_markdown(broken)


@pytest.mark.long
def test_a_verdict_that_is_too_strict_is_found(monkeypatch):
    monkeypatch.setattr(_consistency, "FRACTION_IN_BAND", 0.98)
    assert min(row.p_value for row in nees.rows(range(4))) < NEVER


@pytest.mark.long
def test_a_verdict_without_power_is_found(monkeypatch):
    monkeypatch.setattr(_whiteness, "_LEVEL", 1e-12)
    assert min(row.p_value for row in whiteness.rows(range(6))) < NEVER


def row(hits, trials, promised):
    answers = [True] * hits + [False] * (trials - hits)
    return counted("NEES", "right", "1 run", "rejected", promised, answers)


@pytest.mark.parametrize(
    ("hits", "trials", "promised", "holds"),
    [
        (0, 10, (0, 0.01), True),
        (5, 100, (0.04, 0.06), True),
        (9, 100, (0.04, 0.06), True),  # 4.2 to 16.4 %
        (12, 100, (0.04, 0.06), False),
        (0, 100, (0.04, 0.06), False),
        (100, 100, (0.99, 1), True),
        (90, 100, (0.99, 1), False),
    ],
)
def test_a_promise_holds_if_the_interval_meets_it(hits, trials, promised, holds):
    assert row(hits, trials, promised).holds == holds


def test_the_interval_is_that_of_clopper_and_pearson():
    # the exact limits of 0 of n: 0 and 1 - 0.025^(1/n)
    low, high = row(0, 20, (0, 1)).interval
    assert low == 0
    assert high == pytest.approx(1 - 0.025 ** (1 / 20))


def test_only_what_cannot_be_chance_is_a_broken_promise():
    assert row(3, 30, (0, 0.05)).p_value > 0.05
    assert row(25, 30, (0, 0.05)).p_value < 1e-20
    assert row(0, 30, (0.5, 1)).p_value == pytest.approx(0.5**30)
    assert row(2, 30, (0.0, 1)).p_value == 1


def test_rows_add_up_are_kept_and_are_written(tmp_path):
    rows = measured(22, ["whiteness"], processes=1, kept=tmp_path)
    assert {one.trials for one in rows} == {22}
    assert len(list(tmp_path.iterdir())) == 2
    kept = sorted(tmp_path.iterdir())[0]
    changed = json.loads(kept.read_text())
    changed[0]["hits"] += 1
    kept.write_text(json.dumps(changed))
    again = measured(22, ["whiteness"], processes=1, kept=tmp_path)
    assert again[0].hits == rows[0].hits + 1
    assert again[1:] == rows[1:]
    assert len(as_markdown(rows).splitlines()) == len(rows) + 2
    assert [entry["hits"] for entry in json.loads(as_json(rows))] == [one.hits for one in rows]


def test_rows_of_different_things_do_not_add_up():
    other = Row(**{**row(1, 2, (0, 1)).__dict__, "hypothesis": "wrong"})
    with pytest.raises(AssertionError, match="is not"):
        row(1, 2, (0, 1)).with_more(other)
