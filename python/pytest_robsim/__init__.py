"""The options with which pytest grades a submission, and the fixture `submission`.

Each run of pytest on a machine loads this module; it loads robsim where it is asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from robsim.teach import Submission

_GRADING = "robsim-grading"
_MARKER = (
    "robsim_submission(slots, imports, masked, frames, limits): what a submission may fill, have "
    "and take, as for robsim.teach.Submission"
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("robsim", "grading with robsim (off without --robsim-submission)")
    group.addoption(
        "--robsim-submission",
        metavar="PATH",
        help="What the fixture submission gives: a folder, a Python file, a notebook or a zip of "
        "these. It is run in processes that are shut in. Write it with '='.",
    )
    group.addoption(
        "--robsim-slots",
        metavar="NAMES",
        help="The slots that it may fill, with commas between, for tests without the marker "
        "robsim_submission.",
    )
    group.addoption(
        "--robsim-isolation",
        metavar="LEVEL",
        choices=("auto", "none", "process", "strict"),
        default="auto",
        help="auto: all that works on this machine; strict: end with status 3 unless files, "
        "processes, network and the grader's memory are closed to it; process: limits alone; none: "
        "a process, and nothing else. Default: auto.",
    )
    group.addoption(
        "--robsim-key",
        metavar="FILE",
        help="The key that the seeds of runs come from, written by robsim.teach.Key.new().write. "
        "Default: seeds that nobody knows, and that do not come again.",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Make the marker known."""
    config.addinivalue_line("markers", _MARKER)


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    """Begin to grade, before any conftest.py is run: none may be the submission's."""
    _leave_as_it_is(early_config)
    if early_config.known_args_namespace.robsim_submission is not None:
        from robsim.teach.grading.pytest_plugin import Grading

        early_config.pluginmanager.register(Grading(early_config), _GRADING)


def _leave_as_it_is(config: pytest.Config) -> None:
    """Keep pytest from compiling robsim anew, for the asserts in it, as it has a plugin.

    `import robsim` takes three times as long then. There is no public way to say so.
    """
    hook = getattr(config.pluginmanager, "rewrite_hook", None)
    getattr(hook, "_must_rewrite", set()).discard("robsim")


@pytest.fixture
def submission(request: pytest.FixtureRequest) -> Submission:
    """Return the submission that is graded, a `robsim.teach.Submission`."""
    plugin = request.config.pluginmanager.get_plugin(_GRADING)
    if plugin is None:
        pytest.fail(
            "which submission? python -m pytest --robsim-submission=PATH TESTS.py", pytrace=False
        )
    given: Submission = plugin.submission_for(request.node)
    return given
