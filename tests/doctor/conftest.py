from dataclasses import replace

import pytest

from robsim.teach.doctor.callbacks.scenes import Setting


@pytest.fixture
def small_frames(monkeypatch):
    """Frames of a ninth of the pixels that users get."""
    small = replace(Setting.usual(), resolution=(400, 400))
    monkeypatch.setattr(Setting, "usual", classmethod(lambda _: small))
