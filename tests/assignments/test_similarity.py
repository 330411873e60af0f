"""Programs that are alike or resemble each other: what survives hiding, what does not count."""

import json
import re

import pytest

from graded_results import PROGRAM
from robsim.teach.reports import similarity

OTHER = """
def estimate_state(step):
    if step.measurement is None:
        x, y, heading = last
        left, right = step.last_u
        speed = (left + right) / 2
        turn = (left - right) * 0.0175
        heading += turn
        x += speed * cos(heading)
        y += speed * sin(heading)
        spread = [[9, 0, 0], [0, 9, 0], [0, 0, 0.1]]
    else:
        x, y, heading = step.measurement.pose
        spread = step.measurement.covariance
    for value in (x, y, heading):
        if value != value:
            raise ValueError("lost")
    last[:] = [x, y, heading]
    return Estimate(last, spread)
"""


def renamed(source):
    """Return the same program with other names, numbers, comments and layout."""
    for old, new in (("jacobian", "jj"), ("innovation", "nu"), ("gain", "kk"), ("pose", "xhat")):
        source = re.sub(rf"(?<!\.)\b{old}\b|(?<=self\.){old}\b", new, source)
    source = source.replace("0.001", "7e-3").replace("# The state is a pose.", "# mine, all mine")
    source = source.replace("(self, model):", '(self, model,\n    ):\n        """Mine."""')
    return re.sub(r" ([@+*=-]) ", r"\1", source.replace("\n        ", "\n\n      "))


def changed(source, number):
    """Return a copy with dead code between the lines of methods."""
    lines = source.split("\n")
    for at in range(len(lines) - 1, 0, -4):
        if lines[at].startswith("        "):
            lines.insert(at, f"        self.unused{number} = None")
    return "\n".join(lines)


def program(*texts):
    return similarity.program_of({f"f{i}.py": text.encode() for i, text in enumerate(texts)})


def compared(given=(), others=(), **sources):
    programs = {name: program(text) for name, text in sources.items()}
    others = {name: program(text) for name, text in dict(others).items()}
    return similarity.compared(programs, [program(text) for text in given], others)


def names_of(pairs):
    return [(pair.first, pair.second) for pair in pairs]


def cells(*sources):
    made = [{"cell_type": "code", "metadata": {}, "source": text} for text in sources]
    made.insert(0, {"cell_type": "markdown", "metadata": {}, "source": "# mine"})
    return json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": made}).encode()


@pytest.mark.parametrize(
    "copy",
    [
        program(PROGRAM + OTHER),
        program(renamed(PROGRAM + OTHER)),
        program(OTHER + PROGRAM),
        program(OTHER, PROGRAM),
        similarity.program_of({"a.ipynb": cells("%matplotlib inline", OTHER, "!ls", PROGRAM)}),
        similarity.program_of({"a.ipynb": cells(OTHER, PROGRAM, "print('it works')")}),
    ],
    ids=["to the byte", "renamed", "other order", "files", "notebook", "notebook with more"],
)
def test_programs_that_are_alike_are_a_group(copy):
    programs = {"one": program(PROGRAM + OTHER), "copy": copy, "other": program(OTHER)}
    (group,) = similarity.compared(programs).groups
    assert list(group.names) == ["copy", "one"]
    assert 25 < group.lines < 70


def test_what_stands_before_a_copy_hides_nothing_or_is_told():
    long = ("# x\n" * 50_000, "\n" * 200_000, f"{chr(39) * 3}{'x ' * 99_999}{chr(39) * 3}\n")
    for before in (*long, "x = 1\n" * 20_000):
        found = compared(one=PROGRAM + OTHER, two=before + PROGRAM + OTHER)
        assert [[*group.names] for group in found.groups] == [["one", "two"]]
        assert not found.too_long
    assert compared(one=PROGRAM, two="x = 1\n" * 40_000 + PROGRAM).too_long == ["two"]
    imports = re.sub(r"(?m)^ +(?=self)", r"\g<0>import os; ", PROGRAM)
    assert len(compared(one=PROGRAM, two=imports).groups) == 1


def test_copies_are_listed_however_many_they_are_and_pairs_with_them_too():
    """Many copies counted as common text, and were unlisted."""
    copies = {f"s{i:02}": (PROGRAM, renamed(PROGRAM))[i % 2] for i in range(17)}
    others = {"s17": OTHER, "s18": OTHER + "x = 1\n", "s19": changed(PROGRAM, 1), "s20": "x = 1"}
    found = compared(**copies, **others)
    assert [list(group.names) for group in found.groups] == [[*copies], ["s17", "s18"]]
    assert names_of(found.pairs) == [("s00", "s19")]
    assert found.common_lines == 0


def test_a_copy_with_changes_is_found_with_its_lines():
    found = compared(one=PROGRAM, two=renamed(changed(PROGRAM, 1)), three=OTHER)
    assert names_of(found.pairs) == [("one", "two")]
    assert not found.groups
    left, _ = found.pairs[0].passages[0]
    assert left.text == "\n".join(PROGRAM.split("\n")[left.first_line - 1 : left.last_line])
    assert "kk" in "".join(right.text for _, right in found.pairs[0].passages)


def test_a_part_that_was_copied_is_found_in_a_longer_program():
    (pair,) = compared(one=PROGRAM, two=OTHER + PROGRAM + OTHER.replace("0", "-1")).pairs
    assert pair.share_of_first > 0.9
    assert 0.2 < pair.share_of_second < 0.7


def test_programs_of_ones_own_are_no_pair():
    for one, two in ((PROGRAM, OTHER), ("", ""), ("# mine\n", "import robsim\n")):
        found = compared(one=one, two=two)
        assert not found.groups
        assert not found.pairs


def test_what_all_were_given_does_not_count():
    mine, theirs = PROGRAM + OTHER, PROGRAM + OTHER.replace("2", "2 * y.size")
    assert compared(one=mine, two=PROGRAM).pairs
    assert compared(one=mine, two=theirs, given=[PROGRAM]).pairs
    found = compared(one=mine, two=PROGRAM, three=renamed(PROGRAM), given=[PROGRAM])
    assert not found.groups
    assert not found.pairs


def test_what_many_have_is_left_out_of_pairs_and_told():
    many = {f"s{i:02}": PROGRAM + f"\ndef f(x):\n    return x{'.b' * i}\n" for i in range(12)}
    own = PROGRAM + OTHER
    found = compared(**many, t1=own, t2=own + "\ndef mine(): return -x")
    assert names_of(found.pairs) == [("t1", "t2")]
    assert 10 < found.pairs[0].common_lines < 20
    assert found.common_lines > 12 * 10
    assert list(found.mostly_common) == list(many)


def test_students_are_compared_with_others_and_others_not_with_each_other():
    others = {"shipped solution": PROGRAM, "earlier: anna": changed(PROGRAM, 1), "old": OTHER}
    found = compared(one=renamed(PROGRAM), others={**others, "older": OTHER})
    assert [list(group.names) for group in found.groups] == [["one", "shipped solution"]]
    assert not found.pairs
    found = compared(one=PROGRAM.replace("4.0", "-4.0"), others=others)
    assert names_of(found.pairs) == [("one", "shipped solution")]


def test_pieces_are_named_by_file_and_cell():
    programs = {
        "one": program(PROGRAM),
        "two": similarity.program_of({"s2.ipynb": cells(renamed(PROGRAM) + "\n" + OTHER)}),
        "broken": similarity.program_of({"s3.ipynb": b"{", "data.csv": b"1,2"}),
    }
    (pair,) = similarity.compared(programs).pairs
    assert pair.passages[0][1].file == "s2.ipynb, cell 2"
    assert programs["broken"].pieces == ()


def test_any_text_can_be_compared():
    odd = ["'unterminated", '"""unterminated', "f'{x!r:>{w}}'", "rb'\\'", "\0\0", "0x_1__.e"]
    long = ["'" * 10_000, '"""' * 5_000 + "'", "\\" * 10_000, "(" * 10_000, "a." * 10_000]
    for source in (*odd, *long, ", " * 10_000, "import (\n" * 5_000, "'''\n" * 5_001):
        assert not compared(one=source, two=PROGRAM).pairs


def test_names_numbers_texts_and_layout_are_not_compared():
    same = (
        "import a\nx = self.y + np.dot(z, 3.5)  # sum\n",
        "from a import (\n  b,\n)\nfoo=self.bar+ \\\n np.dot(baz,\n  7e3,)\n",
    )
    assert compared(one=same[0], two=same[1]).groups
    assert not compared(one=same[0], two="x = self.y + np.cross(z, 3.5)").groups
