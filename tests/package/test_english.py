"""The rule of English, checked in new prose (tests/support/english.py)."""

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
    ],
)
def test_new_prose_follows_the_rule(repository, capsys, line, fault):
    (repository / "new.py").write_text(f"{line}\n", "utf-8")
    git("add", "-N", "new.py")
    assert english.main("HEAD") == bool(fault)
    assert fault in capsys.readouterr().out


def test_prose_that_moves_is_not_new(repository, capsys):
    (repository / "old.py").rename(repository / "moved.py")
    git("add", "-A")
    assert not english.main("HEAD")


def test_a_history_without_the_commit_is_an_error():
    with pytest.raises(subprocess.CalledProcessError):
        english.main("0" * 40)
