"""Folders of workers: measured and removed, whatever is in them."""

import os
import sys
import tempfile

import pytest

from robsim.teach.isolation._processes import scratch, written

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="workers run on Unix")


def test_what_lies_too_deep_is_too_much_and_many_small_things_count(tmp_path, monkeypatch):
    for i in range(20):
        (tmp_path / f"f{i}").touch()
    assert written.exceeds(str(tmp_path), 1 << 20)
    assert not written.exceeds(str(tmp_path), 1 << 21)
    monkeypatch.chdir(tmp_path)
    for _ in range(20):
        os.mkdir("x" * 250)
        os.chdir("x" * 250)
    monkeypatch.chdir(tmp_path)
    assert written.exceeds(str(tmp_path), 1 << 40)
    assert not written.exceeds(str(tmp_path / "none"), 0)
    scratch.remove(str(tmp_path / ("x" * 250)))


def test_links_are_removed_and_not_what_they_lead_to(tmp_path):
    kept = tmp_path / "kept"
    (kept / "folder").mkdir(parents=True)
    (kept / "folder" / "file").write_text("kept")
    kept.chmod(0o755)
    folder = tmp_path / "folder"
    (folder / "inner" / "closed").mkdir(parents=True)
    (folder / "to a folder").symlink_to(kept)
    (folder / "inner" / "to a file").symlink_to(kept / "folder" / "file")
    (folder / "inner" / "closed" / "to a folder").symlink_to(kept / "folder")
    (folder / "inner" / "closed").chmod(0)
    (tmp_path / "link").symlink_to(kept)
    scratch.remove(str(folder))
    scratch.remove(str(tmp_path / "link"))  # in the place of a folder
    assert not folder.exists()
    assert (kept / "folder" / "file").read_text() == "kept"
    assert kept.stat().st_mode & 0o777 == 0o755


def left_in(folder):
    scratch.remove_leftovers(str(folder))
    return sorted(os.listdir(folder))


def test_what_nobody_holds_is_removed_and_nothing_else(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    mine, gone = scratch.Base(), scratch.Base()
    scratch.make_scratch(gone.path, None)
    gone.let_go()  # as the end of a process does
    (tmp_path / "robsim-grading").mkdir()
    (tmp_path / "others").mkdir()
    (tmp_path / "others" / "file").write_text("kept")
    (tmp_path / "robsim-grading-link").symlink_to(tmp_path / "others")
    (tmp_path / "robsim-grading-file").write_text("kept")
    kept = ["others", "robsim-grading", "robsim-grading-file", "robsim-grading-link"]
    assert left_in(tmp_path) == sorted([*kept, os.path.basename(mine.path)])
    assert os.listdir(tmp_path / "others") == ["file"]
    mine.remove()
    mine.remove()
    assert left_in(tmp_path) == kept


def test_a_folder_of_another_user_is_kept(tmp_path, monkeypatch):
    (tmp_path / "robsim-grading-x").mkdir()
    monkeypatch.setattr(os, "geteuid", lambda: os.stat(tmp_path).st_uid + 1)
    assert left_in(tmp_path) == ["robsim-grading-x"]


def test_a_folder_that_is_removed_before_it_is_held_is_made_anew(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    make, tries = tempfile.mkdtemp, []

    def slow(prefix):
        tries.append(make(prefix=prefix))
        if len(tries) == 1:
            assert left_in(tmp_path) == []  # another grader removes it at once
        return tries[-1]

    monkeypatch.setattr("tempfile.mkdtemp", slow)
    base = scratch.Base()
    assert len(tries) == 2
    assert os.listdir(tmp_path) == [os.path.basename(base.path)]
    base.remove()
