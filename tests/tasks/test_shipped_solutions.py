"""The solutions that ship: packed as they are written, readable nowhere in what is installed."""

import os
from pathlib import Path

import pytest

import robsim
from robsim.teach import TASKS, Submission, SubmissionError, WorkerLimits, check_isolation
from robsim.teach.exercises import shipped as exercises
from robsim.teach.tasks import solutions as _shipped
from write_solutions import sources_in

COMPILED = (".so", ".pyd", ".pyc")
SOURCES = Path(__file__).parents[2] / "assets/solutions"


@pytest.mark.skipif(not SOURCES.is_dir(), reason="needs the sources")
def test_what_is_packed_is_what_is_written():
    packed = _shipped.unpack(_shipped.PACKED.read_bytes())
    assert packed == sources_in(SOURCES), "run ./run stubs"
    assert packed.keys() == TASKS.keys()


def test_all_are_programs_that_say_what_they_are():
    for kind in TASKS.values():
        said = set()
        for one in kind().solutions:
            assert one.folder is None
            assert one.files.keys() >= set(one.slots)
            for name, content in one.files.items():
                compile(content, name, "exec")
                assert content.startswith(b'"""')
            said.add(tuple(content for _, content in sorted(one.files.items())))
        assert len(said) == len(kind().solutions)


def test_all_do_without_the_room_that_a_course_may_delete():
    solutions = [one for kind in TASKS.values() for one in kind().solutions]
    texts = [content for one in solutions for content in one.files.values()]
    assert not any(b"estimation.reference" in text for text in texts)


@pytest.mark.long
def test_no_file_that_is_installed_shows_one():
    solutions = [one for kind in TASKS.values() for one in kind().solutions]
    texts = {content.decode() for one in solutions for content in one.files.values()}
    for folder, _, names in os.walk(Path(robsim.__file__).parent):
        for file in (Path(folder, name) for name in names if not name.endswith(COMPILED)):
            installed = file.read_text(encoding="utf-8", errors="replace")
            assert not any(text in installed for text in texts), file


def shipped(tmp_path, monkeypatch, changes):
    file = tmp_path / "solutions.bin"
    control = '"control.py" = \'\'\'\n"""One."""\nspeed = 1\n\'\'\'\n'
    base = f'[base]\n{control}"shared.py" = "other"\n[right.reference]\n'
    other = '[base]\n"shared.py" = "b = 1"\n'
    file.write_bytes(_shipped.pack({tmp_path.name: base + changes, "other": other}))
    monkeypatch.setattr(_shipped, "PACKED", file)
    return _shipped.shipped_solutions(tmp_path.name, ("control",))


def test_one_is_the_base_with_changes_in_turn(tmp_path, monkeypatch):
    changes = '[wrong.naive]\nsays = "Two."\n"1" = "2"\n"= 2" = "= 3"\n"more.py" = "a = 1"\n'
    reference, naive = shipped(tmp_path, monkeypatch, changes)
    assert reference.files == {"control": b'"""One."""\nspeed = 1\n', "shared": b"b = 1"}
    assert naive.files["control"] == b'"""Two."""\nspeed = 3\n'
    assert (naive.files["shared"], naive.files["more"]) == (b"b = 3", b"a = 1")
    assert (reference.is_right, naive.is_right) == (True, False)


def test_the_first_and_the_last_words_stand_for_all_between(tmp_path, monkeypatch):
    _, naive = shipped(tmp_path, monkeypatch, '[wrong.naive]\n"One ... speed" = "Two"\n')
    assert naive.files["control"] == b'"""Two = 1\n'


def test_a_change_of_what_is_not_there_is_refused(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"naive.*'velocity'"):
        shipped(tmp_path, monkeypatch, '[wrong.naive]\n"velocity" = "0"\n')


@pytest.mark.parametrize("name", TASKS)
def test_one_that_needs_nothing_masked_is_graded_by_the_masks_of_its_task(name, tmp_path):
    one = TASKS[name](steps=20)
    allowed = [right for right in one.solutions if right.is_right and not _uses(right, one.masked)]
    for module, content in allowed[0].files.items():
        (tmp_path / f"{module}.py").write_bytes(content)
    given = {f"{_shipped.MODULE}.py": _shipped.module_source(one)}
    limits = WorkerLimits(call=300, first_call=300, run=600, cpu=300)
    graded = Submission(tmp_path, slots=one.slots, masked=one.masked, given=given, limits=limits)
    assert len(graded.run(one.scenario, steps=3, seed=1)) == 3


def _uses(solution, masked):
    return any(name.encode() in b"".join(solution.files.values()) for name in masked)


@pytest.mark.long
@pytest.mark.parametrize("packed", [None, _shipped.PACKED, exercises.PACKED])
def test_a_submission_that_is_graded_cannot_unpack_them(tmp_path, packed):
    if packed is not None and not check_isolation().closed["files"]:
        pytest.skip("files are open here")
    assert packed is None or packed.is_file()
    code = f"open({str(packed)!r}, 'rb')" if packed else "robsim.teach.ParkTask().solutions"
    file = tmp_path / "control.py"
    file.write_text(f"import robsim\n{code}\ndef control(step):\n    return 0, 0\n")
    limits = WorkerLimits(first_call=300, run=600)
    graded = Submission(file, slots="control", masked=TASKS["park"]().masked, limits=limits)
    said = packed.name if packed else "robsim.teach.tasks is unavailable"
    with pytest.raises(SubmissionError, match=said):
        graded.run(robsim.Scenario(resolution=(200, 200)), steps=2, seed=1)
