import pytest

import gige_cameras
from surroundings import needs_extension


@pytest.fixture(autouse=True)
def _alone():
    needs_extension("gige")
    with gige_cameras.alone():
        yield


@pytest.fixture
def server(_alone):
    with gige_cameras.served() as server:
        yield server
