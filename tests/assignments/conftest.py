"""A browser for the tests of the pages of grading."""

import pytest

from chromium_browser import running_chromium


@pytest.fixture(scope="module")
def chromium():
    """A running browser; tests without one are skipped."""
    yield from running_chromium()
