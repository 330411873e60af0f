"""``robsim grade --check-isolation`` says what holds, and whether it is enough."""

import dataclasses
import json

import pytest

from commands import command
from robsim.teach import GraderError, IsolationError, check_isolation

pytestmark = pytest.mark.long

CHECK = ("grade", "--check-isolation")
WHERE = "robsim.teach.isolation.check.check_isolation"


@pytest.fixture(scope="module")
def report():
    return check_isolation()


def test_what_holds_is_printed_and_a_level_that_asks_for_little_can_be_had(report):
    run = command(*CHECK)
    assert run.exit_code == 0, run.stderr
    assert "isolation: process" in run.stdout
    told = json.loads(command(*CHECK, "--json").stdout)
    assert told["attempts"] == len(report.attempts)
    run = command(*CHECK, "--isolation", "none")
    assert run.exit_code == 0, run.stderr
    assert "open: " in run.stdout.splitlines()[0]


def test_the_status_says_whether_strict_can_be_had(report, monkeypatch):
    assert command(*CHECK, "--isolation", "strict").exit_code == (0 if report.strict else 3)
    through = {**report.attempts, "connect": (False, "connected")}
    leaky = dataclasses.replace(report, attempts=through)
    monkeypatch.setattr(WHERE, lambda *, isolation: leaky)
    assert command(*CHECK, "--isolation", "strict").exit_code == 3
    assert command(*CHECK).exit_code == 0

    def without_files(*, isolation):
        if isolation == "strict":
            raise IsolationError("isolation='strict' needs files")
        return dataclasses.replace(report, closed={**report.closed, "files": False})

    monkeypatch.setattr(WHERE, without_files)
    run = command(*CHECK, "--isolation", "strict")
    assert run.exit_code == 3
    assert "open: files" in run.stdout
    assert "needs files" in run.stderr


def test_a_machine_that_starts_no_process_is_no_isolation(monkeypatch):
    def nothing(*, isolation):
        raise GraderError("no worker can be started")

    monkeypatch.setattr(WHERE, nothing)
    run = command(*CHECK)
    assert (run.exit_code, run.stdout) == (2, "")
    assert "no worker can be started" in run.stderr


def test_what_cannot_be_checked_is_refused():
    for arguments in (("grade",), (*CHECK, "--isolation", "full")):
        assert command(*arguments).exit_code == 2
