"""Tests that must never get lost, by name: a rename changes its line here, none is deleted."""

import ast
import json
import re
from pathlib import Path

import pytest

from red_team import ATTACKS

TESTS = Path(__file__).parents[1]
CI = TESTS.parent / ".ci/run"

KEPT = {
    "the red team": (
        "grading/red_team/test_red_team.py",
        "test_a_sample_gets_nowhere",
        "test_the_others_get_nowhere",
        "test_with_the_process_alone_none_has_points_and_nothing_runs_on",
    ),
    "the digests": (
        "digests/test_digests.py",
        "test_this_machine_computes_what_others_do",
        "test_other_surroundings_compute_the_same",
        "test_all_instructions_compute_the_same_without_docstrings_and_in_any_order",
    ),
    "the watchdog while the interpreter is held": (
        "motors/test_motor_links.py",
        "test_the_watchdog_needs_no_interpreter",
    ),
    "kill -9 of the grader": (
        "assignments/test_killed.py",
        "test_a_grader_that_is_killed_loses_one_test",
        "test_results_are_whole_whenever_the_grader_is_killed",
    ),
    "kill -9 of a session": (
        "sessions/test_killed.py",
        "test_killed_runs_lose_at_most_one_step",
    ),
    "kill -9 of a campaign": (
        "campaigns/test_faults.py",
        "test_processes_killed_at_random_moments_lose_and_double_nothing",
        "test_a_program_killed_at_random_moments_comes_to_its_end",
    ),
    "parity of worker and one process": (
        "grading/test_parity.py",
        "test_a_submission_that_fills_all_slots_gives_the_same_trace",
        "test_random_slots_in_random_scenarios_give_the_same_trace",
    ),
}

#: Of the C++ tests, which run with the sanitizers: more may come.
CORE_TESTS = 179


@pytest.mark.parametrize("subject", KEPT)
def test_it_is_there_and_runs(subject):
    file, *names = KEPT[subject]
    tree = ast.parse((TESTS / file).read_text())
    tests = {one.name: one for one in ast.walk(tree) if isinstance(one, ast.FunctionDef)}
    for name in names:
        assert name in tests, f"{subject}: {file} has no {name}"
        marks = " ".join(map(ast.unparse, tests[name].decorator_list))
        assert not re.search(r"skip\b|xfail", marks), f"{subject}: {name} is left out"
        assert any(isinstance(one, (ast.Assert, ast.Call)) for one in ast.walk(tests[name]))


def test_the_red_team_only_grows():
    for name, kept in json.loads((TESTS / "data" / "red_team.json").read_text()).items():
        assert name in ATTACKS, f"no attack {name!r}"
        attack = ATTACKS[name]
        assert (attack.comes_to, attack.held_by) == (kept["comes_to"], kept["held_by"]), name


@pytest.mark.skipif(not CI.is_file(), reason="needs the sources")
def test_the_tests_in_c_plus_plus_are_there_and_run_with_the_sanitizers():
    sources = [file.read_text() for file in (TESTS / "core").glob("*.cpp")]
    count = sum(len(re.findall(r"^TEST(?:_F|_P)?\(", source, re.MULTILINE)) for source in sources)
    assert count >= CORE_TESTS
    assert re.search(r"^part \./run sanitize$", CI.read_text(), re.MULTILINE)
