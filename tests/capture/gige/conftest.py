import pytest

import gige_cameras


@pytest.fixture(autouse=True)
def _alone():
    with gige_cameras.alone():
        yield
