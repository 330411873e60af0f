"""The rule of English, checked in new prose (tests/support/english.py)."""

import json
import shutil
import subprocess

import pytest

import english

pytestmark = [
    pytest.mark.skipif(shutil.which("git") is None, reason="needs Git"),
    pytest.mark.usefixtures("repository"),
]

OLD = '"""Return the picture."""\n\n\ndef picture():\n    # Nobody keeps it.\n    return 1\n'


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """Work in a repository with one commit of one file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.py").write_text(OLD, "utf-8")
    git("init", "-q")
    commit()
    return tmp_path


def git(*arguments):
    who = ("-c", "user.name=somebody", "-c", "user.email=somebody@example.org")
    subprocess.run(["git", *who, *arguments], check=True)


def commit():
    git("add", "-A")
    git("commit", "-qm", "A state")


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("# Nobody keeps it.", "Nobody"),
        ('text = "the file is written anew"', "anew"),
        ("# " + "word " * 26, "more than 25 words"),
        ("nobody = anew = 1", ""),
        ("# The view keeps it, `anew` or not.", ""),
        ("# The view has $none$.", ""),
    ],
)
def test_new_prose_follows_the_rule(repository, capsys, line, fault):
    (repository / "new.py").write_text(f"{line}\n", "utf-8")
    git("add", "-N", "new.py")
    assert english.main("HEAD") == bool(fault)
    assert fault in capsys.readouterr().out


def test_cells_of_notebooks_are_read(repository, capsys):
    cells = [
        {"cell_type": "code", "source": ["nobody = 1\n", "# Nobody runs it.\n"]},
        {"cell_type": "markdown", "source": ["# A drive\n", "\n", "Nobody drives.\n"]},
    ]
    text = json.dumps({"cells": cells}, indent=1)
    (repository / "new.ipynb").write_text(text, "utf-8")
    git("add", "-N", "new.ipynb")
    assert english.main("HEAD")
    numbers = [n for n, line in enumerate(text.splitlines(), 1) if "Nobody" in line]
    shown = capsys.readouterr().out.splitlines()
    assert [line.split(":")[:2] for line in shown] == [["new.ipynb", str(n)] for n in numbers]


def test_old_lines_of_pages_are_read(repository, capsys):
    (repository / "README.md").write_text("Nobody reads it.\n", "utf-8")
    commit()
    assert english.main("HEAD")
    assert capsys.readouterr().out.startswith("README.md:1: ")


def test_prose_that_moves_is_not_new(repository, capsys):
    (repository / "old.py").rename(repository / "moved.py")
    git("add", "-A")
    assert not english.main("HEAD")


def test_a_history_without_the_commit_is_an_error():
    with pytest.raises(subprocess.CalledProcessError):
        english.main("0" * 40)
