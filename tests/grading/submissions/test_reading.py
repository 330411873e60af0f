"""Reading submissions of every kind, as students hand them in."""

import pickle

import pytest

import robsim
from submissions import (
    BOTH,
    CONTROL,
    PLAIN,
    Rules,
    answer,
    notebook,
    packed,
    read_submission,
    refused,
    write,
)

DRIVE = "from gains import GAIN\n\n\ndef control(step):\n    return GAIN, GAIN\n"


def test_a_folder_a_zip_a_file_and_a_notebook_are_one_submission(tmp_path):
    folder = write(tmp_path / "s001", control=DRIVE, gains="GAIN = 3.0\n")
    files = {f.name: f.read_text() for f in folder.iterdir()}
    assert answer(folder) == (3, 3)
    assert answer(packed(tmp_path / "s002.zip", files)) == (3, 3)
    in_folders = {f"s003/hw3/{name}": text for name, text in files.items()}
    assert answer(packed(tmp_path / "s003.zip", in_folders)) == (3, 3)
    (tmp_path / "s004.v2.py").write_text(PLAIN)
    assert answer(tmp_path / "s004.v2.py") == (1, 2)
    (tmp_path / "S008.PY").write_text(PLAIN)
    assert answer(tmp_path / "S008.PY") == (1, 2)
    assert answer(notebook(tmp_path / "s005.ipynb", PLAIN)) == (1, 2)
    assert answer(packed(tmp_path / "s006.zip", {"mine.py": PLAIN})) == (1, 2)
    beside = packed(tmp_path / "s007.zip", {"gains.py": "GAIN = 3.0"})
    with_notebook = {"hw.ipynb": notebook(tmp_path / "hw.ipynb", DRIVE).read_text()}
    assert answer(packed(beside, with_notebook | {"gains.py": "GAIN = 3.0"})) == (3, 3)


def test_a_folder_with_a_zip_is_that_zip_as_platforms_hand_it_out(tmp_path):
    folder = tmp_path / "Anna O'Neill_4711_assignsubmission_file_"
    folder.mkdir()
    inside = {"HW1 (2)/control.py": PLAIN, "__MACOSX/HW1 (2)/._control.py": "\0", ".DS_Store": "x"}
    packed(folder / "HW1 final (2).zip", inside)
    for beside in ("report.pdf", ".DS_Store", "onlinetext.html"):
        (folder / beside).write_text("x")
    assert answer(folder) == (1, 2)
    (folder / "older").mkdir()
    assert "is an archive inside" in str(refused(folder))
    (folder / "older").rmdir()
    packed(folder / "HW1 final (3).zip", inside)  # which of them?
    assert "is an archive inside" in str(refused(folder))
    packed(tmp_path / "s002.zip", {"s002/HW1.zip": ""})
    assert "is an archive inside" in str(refused(tmp_path / "s002.zip"))


def test_what_a_submission_is_stands_in_it(tmp_path):
    folder = write(tmp_path / "s001", control=PLAIN, measure="def measure(step): ...\n")
    (folder / "table.csv").write_text("1,2")
    found = read_submission(folder, BOTH)
    assert (found.name, found.kind, found.main) == ("s001", "folder", "")
    assert found.slots == ("control", "measure")
    assert set(found.sources) == {"control.py", "measure.py", "table.csv"}
    assert pickle.loads(pickle.dumps(found)) == found
    only = read_submission(folder, CONTROL)
    assert only.slots == ("control",)
    assert "measure.py" in only.notes[0]


def test_a_misspelled_name_is_told(tmp_path):
    folder = write(tmp_path / "s001", contrl=PLAIN, other="")
    assert "contrl.py" in str(refused(folder))
    folder = write(tmp_path / "s002", control=PLAIN, measur="")
    error = refused(folder, BOTH)
    assert "measure.py" in str(error)
    assert error.file == "measur.py"
    control = "from measurement import GAIN\n\n\ndef control(step):\n    return GAIN, GAIN\n"
    helps = write(tmp_path / "s003", control=control, measurement="GAIN = 2")  # it resembles one
    assert answer(helps, BOTH) == (2, 2)


def test_helpers_that_would_not_be_found_are_told(tmp_path):
    folder = write(tmp_path / "s001", control="import json\n" + PLAIN, json="")
    assert "'json.py' has the name of a module" in str(refused(folder))
    assert answer(write(tmp_path / "s002", control=PLAIN, json="")) == (1, 2)
    folder = write(tmp_path / "s003", control="from lib import gains\n" + PLAIN)
    write(folder / "lib", gains="GAIN = 1")
    assert "'lib' is a folder of modules" in str(refused(folder))


def test_what_tools_leave_does_not_count(tmp_path):
    leftovers = ["__MACOSX/._control.py", ".DS_Store", "__pycache__/x.pyc", ".git/HEAD"]
    leftovers += [".ipynb_checkpoints/old.ipynb", "Thumbs.db"]
    files = dict.fromkeys(leftovers, b"\0\xff") | {"control.py": PLAIN}
    found = read_submission(packed(tmp_path / "s001.zip", files), CONTROL)
    assert [*found.sources] == ["control.py"]
    for name, content in files.items():
        (tmp_path / "s002" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "s002" / name).write_bytes(content if name in leftovers else PLAIN.encode())
    assert [*read_submission(tmp_path / "s002", CONTROL).sources] == ["control.py"]


def test_a_report_may_have_any_size(tmp_path):
    small = Rules(slots=("control",), size=1000, file_size=1000)
    files = {"control.py": PLAIN, "Report.PDF": "x" * 2000}
    zipped = packed(tmp_path / "s001.zip", files)
    folder = write(tmp_path / "s002", control=PLAIN)
    (folder / "Report.PDF").write_text(files["Report.PDF"])
    for path in (zipped, folder):
        assert read_submission(path, small).sources["Report.PDF"] == b""
    (folder / "Report.PDF").rename(folder / "table.csv")
    assert "'table.csv' has more than 1000 bytes" in str(refused(folder, small))


def test_a_file_without_effect_is_noted(tmp_path):
    folder = write(tmp_path / "s001", control=PLAIN, task="DT = 0.1\r\n")
    notebook(folder / "hw1.ipynb", PLAIN)
    (note,) = read_submission(folder, CONTROL, {"task.py": b"DT = 0.1\n"}).notes
    assert "hw1.ipynb is not used, because control.py" in note
    _, note = read_submission(folder, CONTROL, {"task.py": b"DT = 0.2\n"}).notes
    assert "changes to it do not count" in note
    assert "task.py" in note


def test_a_submission_without_a_slot_is_told(tmp_path):
    for files, words in (
        ({}, "no control.py"),
        ({"readme.txt": "hello"}, "no control.py: it has readme.txt"),
        ({"measure.py": ""}, "no control.py: it has measure.py"),
        ({"a.ipynb": "", "b.ipynb": ""}, "2 notebooks, a.ipynb, b.ipynb"),
        ({"mine.py": "x = 1"}, "mine.py fills no slot"),
    ):
        assert words in str(refused(packed(tmp_path / "s001.zip", files)))


def test_what_cannot_be_a_submission(tmp_path):
    (tmp_path / "s001.txt").write_text("hello")
    assert "s001.txt" in str(refused(tmp_path / "s001.txt"))
    assert "is missing" in str(refused(tmp_path / "s002"))


@pytest.mark.long
def test_what_is_no_python_is_told_with_its_line(tmp_path):
    (tmp_path / "s001").mkdir()
    for source, words in (
        (b"def control(step:\n    pass", "line 1: "),
        (b"x = 1\n\ny = \xe9", "line 3: it is not UTF-8 text, it has the byte 0xe9"),
        (b"x = 1\n\0", "line 2: it is not UTF-8 text, it has a null character"),
        (b"# coding: ascii\nx = '\xe9'", "line 2: it is not ASCII text, it has the byte 0xe9"),
        (b"# coding: hex\nx = 1", "line 1: it declares the coding 'hex'"),
        (b"# coding: punycode\nx = 1", "line 1: it declares the coding 'punycode'"),
        (b"# coding: unicode_escape\nx = 1", "line 1: it declares the coding 'unicode_escape'"),
        (b"\n# coding=utf7\nx = 1", "line 2: it declares the coding 'utf7'"),
        (b"x = " + b"-" * 100_000 + b"1", "nested too deeply"),
        (b"x" + b"()" * 50_000, "nested too deeply"),
        (b"import " + b"a." * 100_000 + b"a", "more than 64 dots"),
        (b"import " + b"a.\\\n" * 1_000 + b"a", "more than 64 dots"),
        (b"import " * 140_000, "line 1: "),
        (b"a" * 1_000_000 + b"! b", "line 1: invalid syntax"),
        (b"x\n" * 300_000, "has 300000 words and signs, more than the allowed 250000"),
        (b"x = '\x1b[31m\xe2\x80\xae\n", "line 1: unterminated string"),
        (b"x = " + b"9" * 10_000, "line 1: "),
    ):
        (tmp_path / "s001/control.py").write_bytes(source)
        error = refused(tmp_path / "s001")
        assert words in str(error)
        assert str(error).isprintable()
        assert len(str(error)) < 500
        assert error.file == "control.py"


CODED = """# -*- coding: {} -*-
from helper import NAME
def control(step):
    return "gr\xfc\xdfe", NAME
"""


@pytest.mark.parametrize("coding", ["latin-1", "cp1252", "iso-8859-15", "utf-8", "utf_8_sig"])
def test_a_line_with_the_coding_counts_as_in_python(tmp_path, coding):
    helper = f"#!/usr/bin/python\n# vim: set fileencoding={coding} :\nNAME = '\xe9'\n"
    folder = write(tmp_path / "s001", control="")
    (folder / "control.py").write_bytes(CODED.format(coding).encode(coding))
    (folder / "helper.py").write_bytes(helper.encode(coding))
    assert answer(folder) == ("gr\xfc\xdfe", "\xe9")
    assert robsim.teach.check_folder(folder).checks["control"].problems[0].kind != "not loaded"
    alone = f"# coding: {coding}\n" + "def control(step):\n    return '\xe4'\n"
    (tmp_path / "mine.py").write_bytes(alone.encode(coding))
    assert answer(tmp_path / "mine.py") == "\xe4"


def test_a_coding_below_the_first_line_of_code_does_not_count(tmp_path):
    assert answer(write(tmp_path / "s001", control=f"x = 1\n# coding: hex\n{PLAIN}")) == (1, 2)


def test_a_helper_that_nobody_imports_may_be_broken(tmp_path):
    assert answer(write(tmp_path / "s001", control=PLAIN, old="def (")) == (1, 2)
    folder = write(tmp_path / "s002", control="import old\n" + PLAIN, old="\ndef (")
    assert str(refused(folder)).startswith("old.py, line 2: invalid syntax")


def test_rules_are_plain_values():
    masked = ["robsim.estimation.reference"]
    rules = Rules(slots=["control"], imports=["numpy"], masked=masked, files=3)
    assert rules.slots == ("control",)
    for wrong in (
        {"slots": ["contrl"]},
        {"masked": ["robsim; x"]},
        {"masked": ["robsim.referense"]},
        {"imports": ["numpy", "scipy.linalg"]},
        {"ratio": 0},
    ):
        with pytest.raises(ValueError, match=r"slots|masked|imports|ratio|robsim\.referense"):
            Rules(**wrong)
    assert Rules(masked=["robsim.locate", "robsim.vision.locate", "not_installed.x"]).masked
