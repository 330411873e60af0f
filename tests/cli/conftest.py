import pytest


@pytest.fixture
def undrawn(monkeypatch):
    """The figures of a run are empty files: to draw them takes longer than all else."""
    monkeypatch.setattr("robsim.cli.results.save_figure", lambda file, figure: file.touch())
