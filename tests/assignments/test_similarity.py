"""Similarity of programs: what survives hiding, what is no copy, what does not count."""

import json
import re

from graded_results import PROGRAM
from robsim.teach.reports import similarity as pairs
from robsim.teach.reports import similarity as tokens
from robsim.teach.reports import similarity as winnowing

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
        source = re.sub(rf"\b{old}\b(?!\()", new, source)
    source = source.replace("0.001", "7e-3").replace("# The state is a pose.", "# mine, all mine")
    return re.sub(r" ([@+*=-]) ", r"\1", source.replace("\n        ", "\n\n      "))


def pairs_of(given=(), **sources):
    def program(text):
        return winnowing.program_of({"control.py": text.encode()})

    programs = {name: program(text) for name, text in sources.items()}
    return pairs.similar_pairs(programs, [program(text) for text in given])


def test_a_copy_in_disguise_is_found_with_its_lines():
    (pair,) = pairs_of(one=PROGRAM, two=renamed(PROGRAM), three=OTHER)
    assert (pair.first, pair.second) == ("one", "two")
    assert pair.share_of_first > 0.9
    assert pair.share_of_second > 0.9
    left, right = pair.passages[0]
    assert "np.linalg.inv" in left.text
    assert "np.linalg.inv" in right.text
    assert "kk" in right.text
    assert left.text == "\n".join(PROGRAM.split("\n")[left.first_line - 1 : left.last_line])


def test_a_part_that_was_copied_is_found_in_a_longer_program():
    (pair,) = pairs_of(one=PROGRAM, two=OTHER + PROGRAM + OTHER.replace("0", "1"))
    assert pair.share_of_first > 0.9
    assert 0.3 < pair.share_of_second < 0.7


def test_programs_of_ones_own_are_no_pair():
    assert pairs_of(one=PROGRAM, two=OTHER) == []
    assert pairs_of(one="", two="") == []
    assert pairs_of(one="x = 1\n", two="x = 1\n") == []


def test_what_all_were_given_does_not_count():
    mine, theirs = OTHER, PROGRAM
    assert pairs_of(one=PROGRAM + mine, two=PROGRAM + theirs) != []
    assert pairs_of(one=PROGRAM + mine, two=PROGRAM, given=[PROGRAM]) == []


def test_what_many_have_does_not_count():
    few = pairs_of(**{f"s{i}": PROGRAM for i in range(10)})
    assert len(few) == 45
    assert pairs_of(**{f"s{i}": PROGRAM for i in range(11)}) == []


def test_cells_of_notebooks_are_compared():
    text = renamed(PROGRAM).splitlines(True)
    cells = [
        {"cell_type": kind, "metadata": {}, "source": source}
        for kind, source in (("markdown", "# mine"), ("code", text))
    ]
    notebook = {"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells}
    programs = {
        "one": winnowing.program_of({"state.py": PROGRAM.encode()}),
        "two": winnowing.program_of({"s2.ipynb": json.dumps(notebook).encode()}),
        "broken": winnowing.program_of({"s3.ipynb": b"{", "data.csv": b"1,2"}),
    }
    (pair,) = pairs.similar_pairs(programs)
    assert pair.passages[0][1].file == "s2.ipynb, cell 2"
    assert programs["broken"].pieces == ()


def test_winnowing_finds_whatever_is_long_enough(rng):
    long_enough = winnowing.RUN + winnowing.WINDOW - 1
    numbers = rng.integers(0, 30, 3 * (long_enough + 1))
    part = " ".join(f".{'abcdefghij'[k % 10] * (k + 1)}" for k in numbers.tolist())
    all_tokens = tokens.tokens_of(part)
    hashes = {each.hash for each in winnowing.winnowed(all_tokens, 0)}
    for start in rng.integers(0, len(numbers) - long_enough, 20):
        common = all_tokens[2 * start : 2 * start + long_enough]
        assert hashes & {each.hash for each in winnowing.winnowed(common, 0)}
    assert winnowing.winnowed(all_tokens[: winnowing.RUN - 1], 0) == []


def test_any_text_has_tokens():
    odd = ["'unterminated", '"""unterminated', "f'{x!r:>{w}}'", "rb'\\'", "\0\0", "0x_1__.e"]
    long = ["'" * 10_000, '"""' * 5_000 + "'", "\\" * 10_000, "(" * 10_000, "a." * 10_000]
    for source in odd + long:
        assert isinstance(tokens.tokens_of(source), list)


def test_names_numbers_texts_and_layout_are_not_compared():
    same = ("import a\nx = self.y + np.dot(z, 3.5)  # sum\n", "foo=self.bar+ np.dot(baz,\n  7e3)\n")
    one, two, other = (
        [token.kind for token in tokens.tokens_of(text)]
        for text in (*same, "x = self.y + np.cross(z, 3.5)")
    )
    assert one == two != other
    assert [token.line for token in tokens.tokens_of("'''a\nb'''\nc")] == [1, 3]
