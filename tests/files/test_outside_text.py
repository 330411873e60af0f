"""Text from files and users: escaped in HTML, harmless in a terminal, no formula in a table."""

import os
import re
from contextlib import chdir
from dataclasses import dataclass
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from commands import command
from robsim import vision as imaging
from robsim.base.text import as_cell, cut, listed, one_line, printable, quoted
from robsim.estimation import Column, Quantity, Report, Row, Table
from robsim.teach import Problem, SourceLine

HOSTILE = "<img src=x onerror=alert(1)>\"'&\x1b]0;t\x07\x9b31m\u202e\n=1+1 $x^2$"
TEXTS = st.text(max_size=30) | st.just(HOSTILE)


def is_harmless(text, breaks=""):
    return all(
        c in breaks or (c not in "\x7f\u202a\u202e\u2066" and ord(c) > 31) for c in text
    ) and not (re.search("[\x80-\x9f\u2028\u2029\ud800-\udfff]", text))


@settings(max_examples=50)
@given(TEXTS)
def test_escaped_text_has_nothing_that_commands_a_terminal(text):
    assert is_harmless(one_line(text))
    assert is_harmless(printable(text), breaks="\n\t")
    if text.isprintable():
        assert one_line(text) == printable(text) == text


@pytest.mark.long
@settings(max_examples=30)
@given(
    st.recursive(TEXTS | st.integers() | st.binary(), lambda values: st.lists(values, max_size=9))
)
def test_what_a_message_quotes_is_short(value):
    for text in (quoted(value), quoted([value] * 20), quoted({str(value): value})):
        assert len(text) <= 60
        assert is_harmless(text)


def test_other_short_texts():
    assert len(quoted(10**5000)) <= 60
    assert len(cut("x" * 10**6)) <= 200
    assert listed("abc") == "a, b, c"
    assert listed(map(str, range(12))).startswith("0, 1, 2, 3, 4, 5, 6, 7, 8, 9, ...")


class Loud:
    def __repr__(self):
        return "\x1b[2J" * 1000


class Mute:
    def __repr__(self):
        raise ZeroDivisionError


def test_what_came_is_quoted_whatever_its_repr():
    sim = robsim.Simulation(seed=1)
    for value in (Loud(), Mute(), [Loud()] * 100, ["x" * 10**6, Mute()]):
        for name, call in {
            "x": lambda value: robsim.GoToPoint(value, 1),
            "u": robsim.Replay,
            "percent": robsim.GaussianNoise,
            "seed": lambda value: robsim.Simulation(seed=value),
            "groups": lambda value: robsim.Trace(value, sim.run(2).info),
            "steps": sim.run,
            "parameters": robsim.RobotModel,
        }.items():
            with pytest.raises((TypeError, ValueError), match=name) as caught:
                call(value)
            assert is_harmless(str(caught.value), breaks="\n"), name
            assert len(str(caught.value)) < 500, name


def test_names_that_can_be_shown():
    for name in ("x", "größe", "赤い", "a b", "7_1", "x" * 40, "é" * 40):
        assert robsim.ColorClass(name).name == name
    hidden = ("a\0b", "a\nb", "\x1b[2J", "\u202ea", "a\u2028b", "\x9b", "\ud800")
    for name in (*hidden, "", "x" * 41, "<b>", "=1+1", "$(id)", "-rf", " "):
        for make in (
            robsim.ColorClass,
            lambda name: robsim.ColorClass.from_histograms(np.ones((3, 256)), name=name),
        ):
            with pytest.raises((ValueError, TypeError), match="name") as caught:
                make(name)
            assert is_harmless(str(caught.value))
            assert len(str(caught.value)) < 200


# --- reports


@dataclass(frozen=True)
class Hostile(Report):
    """A report whose every text came from outside."""

    text: str

    title = property(lambda self: self.text)
    verdict = property(lambda self: self.text)
    remarks = property(lambda self: [self.text])

    @property
    def quantities(self):
        return [Quantity(self.text, self.text, self.text, self.text, missing=self.text)]

    @property
    def tables(self):
        columns = [Column(self.text, self.text, self.text)]
        rows = [Row(self.text, [value], self.text) for value in (self.text, None)]
        return [Table(key=self.text, columns=columns, rows=rows, row_title=self.text)]

    @property
    def problems(self):
        line = SourceLine(self.text, 3, self.text)
        t = self.text
        return [Problem(kind=t, sentence=t, situation=t, k=1, line=line)]


ALLOWED = {"div", "p", "b", "table", "thead", "tbody", "tr", "th", "td", "ol", "ul", "li", "br"} | {
    *("small", "code")
}


class Elements(HTMLParser):
    """The elements, and the text between them."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.tags, self.content = set(), ""

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        assert all(name == "style" for name, _ in attrs)

    def handle_data(self, data):
        self.content += data


def check_html(text):
    parser = Elements()
    parser.feed(text)
    parser.close()
    assert parser.tags <= ALLOWED
    assert is_harmless(parser.content, breaks="\n\t")
    return parser.content


@settings(max_examples=30)
@given(TEXTS)
def test_a_report_shows_every_text_and_runs_none(text):
    report = Hostile(text)
    content = check_html(report._repr_html_())
    assert content.count(printable(text)) >= 8
    assert is_harmless(str(report), breaks="\n")
    assert is_harmless(repr(report))
    assert is_harmless(report.line)


def test_a_formula_is_a_text():
    for text in ("=1", "+1", "-1", "@x", "\tx", "\rx", " =1", "\uff1d1", "'=1"):
        assert as_cell(text) == "'" + text
        assert as_cell("x" + text) == "x" + text


# --- errors, warnings, the shell

STRANGE = "a\x1b]0;t\x07\u202e\nb"


@pytest.mark.skipif(os.name == "nt", reason="no such names")
def test_names_of_files_in_errors(tmp_path):
    folder = tmp_path / STRANGE
    folder.mkdir()
    for suffix in (".toml", ".npz", ".png", ".mkv"):
        (folder / f"{STRANGE}{suffix}").write_text("neither this nor that")
    (folder / "robot.toml").write_text("a = 1")
    file = folder / STRANGE
    calls = (
        lambda: robsim.load_colors(f"{file}.toml"),
        lambda: robsim.Scenario.load(f"{file}.toml"),
        lambda: robsim.Trace.load(f"{file}.npz"),
        lambda: imaging.load_image(f"{file}.png"),
        lambda: robsim.Recording(f"{file}.mkv"),
        lambda: robsim.load_robot(folder),
        lambda: imaging.save_image(file, np.zeros((4, 4, 3), np.uint8)),
        lambda: imaging.save_video(file, [], fps=5),
        lambda: imaging.Clip([np.zeros((4, 4, 3), np.uint8)], fps=5).save(file),
        lambda: robsim.Simulation.from_folder(folder),
        lambda: robsim.Simulation(robot=STRANGE),
    )
    for call in calls:
        with pytest.raises((ValueError, OSError, TypeError)) as caught:
            call()
        assert is_harmless(str(caught.value)), str(caught.value)


@pytest.mark.skipif(os.name == "nt", reason="no such names")
@pytest.mark.long
def test_names_of_files_in_the_shell(tmp_path):
    (tmp_path / f"{STRANGE}.toml").write_text("[red]\nu = [0, 100]\n")
    imaging.save_image(tmp_path / f"{STRANGE}.png", np.zeros((16, 16, 3), np.uint8))
    with chdir(tmp_path):
        for arguments in (
            ("colors", "list", f"{STRANGE}.toml"),
            ("colors", "test", f"{STRANGE}.png", "--out", f"{STRANGE}2.png"),
            ("robots", "show", STRANGE),
            ("new", STRANGE),
            ("run", f"{STRANGE}2"),
            ("track", f"{STRANGE}.png"),
        ):
            run = command(*arguments)
            for stream in (run.stdout, run.stderr):
                assert is_harmless(stream, breaks="\n"), (arguments, stream)
                assert not re.search(r"^b", stream, re.MULTILINE), (arguments, stream)
