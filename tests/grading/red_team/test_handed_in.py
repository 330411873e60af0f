"""Attacks by what is handed in: archives, notebooks, folders, told before and while they run."""

import json
import os
import stat
import sys
import zipfile

import pytest

import robsim
from robsim.grading import Submission, SubmissionError
from robsim.grading._isolation._processes.zygotes import close_zygotes

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="submissions run on Unix")

CONTROL = "def control(step): return 0.1, 0.2\n"
SCENARIO = robsim.Scenario(resolution=(200, 200), measure=True)


@pytest.fixture(scope="module", autouse=True)
def _no_zygote_is_left():
    yield
    close_zygotes()


def zip_of(path, entries):
    """Write a zip; a name with a mode writes a link or a device."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries:
            info = zipfile.ZipInfo(*name) if isinstance(name, tuple) else zipfile.ZipInfo(name)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, data)
    return path


def linked(name, mode=stat.S_IFLNK | 0o777):
    info = zipfile.ZipInfo(name)
    info.external_attr = mode << 16
    info.create_system = 3
    return info


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ([("control.py", CONTROL), ("../left.py", "x")], r"\.\."),
        ([("control.py", CONTROL), ("/etc/left", "x")], "/etc|absolute"),
        ([("control.py", CONTROL), ("x" * 5000, "x")], "name|long"),
        ([("control.py", CONTROL), ("a.txt", "0" * 900_000)], "times|smaller|larger|ratio"),
        ([("control.py", CONTROL), ("CONTROL.py", CONTROL)], "one file on some systems"),
    ],
    ids=["climbs", "absolute", "a long name", "a bomb", "names that are one"],
)
def test_zips_with_tricks_are_refused_before_anything_runs(tmp_path, entries, said):
    with pytest.raises(SubmissionError, match=said):
        Submission(zip_of(tmp_path / "s.zip", entries), slots="control")
    assert os.listdir(tmp_path) == ["s.zip"]


@pytest.mark.parametrize("mode", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR])
def test_zips_with_links_and_devices_are_refused(tmp_path, mode):
    with zipfile.ZipFile(tmp_path / "s.zip", "w") as archive:
        archive.writestr("control.py", CONTROL)
        archive.writestr(linked("data.txt", mode | 0o777), "/etc/passwd")
    with pytest.raises(SubmissionError, match=r"data\.txt"):
        Submission(tmp_path / "s.zip", slots="control")


def test_a_link_out_of_a_folder_shows_nothing_of_what_it_leads_to(tmp_path):
    folder = tmp_path / "s"
    folder.mkdir()
    (tmp_path / "key").write_text("a secret of the teacher's")
    (folder / "control.py").symlink_to(tmp_path / "key")
    with pytest.raises(SubmissionError, match="link") as failed:
        Submission(folder, slots="control")
    assert "secret" not in str(failed.value)


@pytest.mark.long
def test_a_notebook_runs_its_slot_and_nothing_else(tmp_path):
    left = tmp_path / "left"
    cells = [
        f"!touch {left}",
        f"%%bash\ntouch {left}",
        f"open({str(left)!r}, 'w')",
        "from IPython.display import HTML, Javascript, display\n"
        "display(HTML('<script>alert(1)</script>'))",
        "get_ipython().run_cell('1')",
        CONTROL,
    ]
    content = {
        "nbformat": 4,
        "nbformat_minor": 5,
        "metadata": {"kernelspec": {"name": "bash", "argv": ["touch", str(left)]}},
        "cells": [
            {
                "cell_type": "code",
                "id": f"c{i}",
                "metadata": {},
                "execution_count": 1,
                "outputs": [{"output_type": "display_data", "data": {"text/html": "<script>"}}],
                "source": cell,
            }
            for i, cell in enumerate(cells)
        ],
    }
    (tmp_path / "s.ipynb").write_text(json.dumps(content))
    submission = Submission(tmp_path / "s.ipynb", slots="control")
    trace = submission.run(SCENARIO, steps=5, seed=1)
    assert (trace.u == [0.1, 0.2]).all()
    assert submission.output == ""
    assert not left.exists()


@pytest.mark.long
@pytest.mark.parametrize("name", ["\x1b[31m\n.py", "\u202egnp.py", "-rf.py", "a\x07.py"])
def test_names_of_files_reach_no_message_as_they_are(tmp_path, name):
    path = tmp_path / name
    path.write_text("1 / 0\ndef control(step): return 0, 0\n")
    with pytest.raises(SubmissionError) as failed:
        Submission(path, slots="control").run(SCENARIO, steps=1, seed=1)
    assert str(failed.value).isprintable()
