"""The policy of deprecations (site, stability): a warning for one minor release, then removal."""

import ast
import inspect
from pathlib import Path

import pytest

import robsim
from robsim.base.deprecated import warn_deprecated

PACKAGE = Path(robsim.__file__).parent


def numbers(version):
    return tuple(int(part) for part in version.split("."))


def faults(source, version):
    """Return each call that breaks the policy: warned in one minor release, gone in a later one."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "warn_deprecated":
            given = {key.arg: ast.literal_eval(key.value) for key in node.keywords}
            since, gone_in = numbers(given["since"]), numbers(given["gone_in"])
            if not since <= numbers(version) < gone_in or since[:2] >= gone_in[:2]:
                found.append(f"line {node.lineno}: {given}")
    return found


def test_deprecated_names_follow_the_policy():
    for file in PACKAGE.rglob("*.py"):
        assert faults(file.read_text(encoding="utf-8"), robsim.__version__) == [], file


@pytest.mark.parametrize(
    ("since", "gone_in", "version", "count"),
    [
        ("0.2.0", "0.3.0", "0.2.0", 0),
        ("0.2.0", "0.3.0", "0.2.4", 0),
        ("0.2.0", "0.3.0", "0.3.0", 1),  # overdue
        ("0.3.0", "0.4.0", "0.2.0", 1),  # announced by a version that does not exist
        ("0.2.0", "0.2.1", "0.2.0", 1),  # gone in a patch release
    ],
)
def test_the_reader_finds_a_breach(since, gone_in, version, count):
    call = f"warn_deprecated('f', since={since!r}, gone_in={gone_in!r}, instead='g')"
    assert len(faults(call, version)) == count


def test_the_warning_names_the_line_the_versions_and_the_successor():
    said = r"robsim\.f .*0\.2\.0.*0\.3\.0.*robsim\.g"
    line = inspect.currentframe().f_lineno + 2
    with pytest.warns(DeprecationWarning, match=said) as warned:
        warn_deprecated("robsim.f", since="0.2.0", gone_in="0.3.0", instead="robsim.g")
    assert (warned[0].filename, warned[0].lineno) == (__file__, line)
