"""Options for grading a submission with pytest, and the fixture `submission`.

Each run of pytest on a machine loads this module; it imports robsim only for grading.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from robsim.teach import Submission

_GRADING = "robsim-grading"
_MARKER = (
    "robsim_submission(slots, imports, masked, frames, limits): the slots, imports, masked names, "
    "frames and limits of a submission, as for robsim.teach.Submission"
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("robsim", "grading with robsim (off without --robsim-submission)")
    group.addoption(
        "--robsim-submission",
        metavar="PATH",
        help="The submission for the fixture: a folder, a Python file, a notebook or a zip of "
        "these. It runs in sandboxed processes. Write the option with '='.",
    )
    group.addoption(
        "--robsim-slots",
        metavar="NAMES",
        help="The slots that the submission may fill, separated by commas, for tests without the "
        "marker robsim_submission.",
    )
    group.addoption(
        "--robsim-isolation",
        metavar="LEVEL",
        choices=("auto", "none", "process", "strict"),
        default="auto",
        help="auto = every isolation that works on this machine. strict = end with status 3 unless "
        "files, processes, network and the grader's memory are isolated. process = limits only. "
        "none = a separate process only. Default: auto.",
    )
    group.addoption(
        "--robsim-key",
        metavar="FILE",
        help="The key for the seeds of runs, written by robsim.teach.Key.new().write. "
        "Default: secret seeds that never repeat.",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker."""
    config.addinivalue_line("markers", _MARKER)


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    """Start grading before any conftest.py runs, because a submission may contain one."""
    _leave_as_it_is(early_config)
    if early_config.known_args_namespace.robsim_submission is not None:
        from robsim.teach.grading.pytest_plugin import Grading

        early_config.pluginmanager.register(Grading(early_config), _GRADING)


def _leave_as_it_is(config: pytest.Config) -> None:
    """Keep pytest from rewriting robsim's asserts, as pytest does for packages with a plugin.

    Rewriting triples the time of `import robsim`; pytest has no public way to prevent it.
    """
    hook = getattr(config.pluginmanager, "rewrite_hook", None)
    getattr(hook, "_must_rewrite", set()).discard("robsim")


@pytest.fixture
def submission(request: pytest.FixtureRequest) -> Submission:
    """Return the graded submission, a `robsim.teach.Submission`."""
    plugin = request.config.pluginmanager.get_plugin(_GRADING)
    if plugin is None:
        pytest.fail(
            "no submission; run python -m pytest --robsim-submission=PATH TESTS.py", pytrace=False
        )
    given: Submission = plugin.submission_for(request.node)
    return given
