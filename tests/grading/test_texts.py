"""Texts of students: harmless wherever they are shown."""

import html
import json
import pickle
import re
import xml.etree.ElementTree as ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from robsim.teach import (
    AssignmentError,
    GraderError,
    GradingError,
    SubmissionError,
    clean_text,
    fenced,
)
from robsim.teach.texts import ErrorText, clean_line, error_text

NASTY = [
    "\x1b[31mred\x1b]0;title\x07", "a\0b", "\u202egnp.exe", "\ud800", "\ufffe\uffff",
    "\u2066x\u2069", "]]>", "</pre><script>", "```\n# heading",
    "a\u0300\u0301\u0302\u0303\u0304" * 3,
    "\x85\u2028",    "\U000e0041", "\ufeff", "\u200b", "\x9b31m", "\r\rover", "\b\b\b", "\x7f",
]  # fmt: skip


def harmless(text):
    assert all(c in "\n\t" or c.isprintable() for c in text), ascii(text)
    element = ElementTree.Element("failure", message=text)
    element.text = text
    read = ElementTree.fromstring(ElementTree.tostring(element))
    assert read.text == (text or None)
    assert json.loads(json.dumps(text)) == text
    text.encode()
    return True


@pytest.mark.long
@given(st.text(st.characters(), max_size=300) | st.lists(st.sampled_from(NASTY)).map("".join))
def test_any_text_is_harmless(text):
    assert harmless(clean_text(text, 200))
    assert len(clean_text(text, 200)) <= 200
    assert len(clean_line(text, 50)) <= 50
    assert "\n" not in clean_line(text)
    assert html.unescape(html.escape(clean_text(text))) == clean_text(text)
    block = fenced(text).split("\n")
    fence = block[-1]
    assert re.fullmatch("`{3,}", fence)
    assert block[0] == f"{fence}text"
    assert all(fence not in line for line in block[1:-1])


def test_what_is_harmless_stays():
    text = "déjà vu: 3 * 4\n\tπ ≈ 3.14 日本"
    assert clean_text(text) == text
    assert "\x1b" not in clean_text(NASTY[0])
    assert clean_text("a\r\nb") == "a\nb"
    assert clean_line("a\nb") == "a\\nb"


def test_a_long_text_is_cut_before_it_is_looked_at():
    class Counted(str):
        pass

    assert clean_text("x" * 100_000_000) == "x" * 3996 + " ..."
    assert clean_text(Counted("x")) == "<Counted>"  # which may do anything when it is cut
    assert clean_text("xx", 0) == ""
    with pytest.raises(ValueError, match="most"):
        clean_text("x", -1)
    assert clean_line(3) == "<int>"


def raised(code, **names):
    """The exception of a student's code."""
    try:
        exec(compile(code, "control.py", "exec"), names)
    except BaseException as error:
        return error
    raise AssertionError("nothing was raised")


@pytest.mark.parametrize("method", ["__str__", "__repr__", "__getattribute__", "__getattr__"])
def test_nothing_of_the_students_is_called_for_a_text(method):
    for body in ("raise SystemExit(0)", "raise KeyboardInterrupt", "while True: pass",
                 "return 'x' * 10**12", "import os; os._exit(0)"):  # fmt: skip
        define = f"    def {method}(self, *a):\n        {body}\n"
        code = f"class Mine(Exception):\n{define}\nclass Plain:\n{define}\n"
        for last in ("raise Mine('why')", "raise Mine(Plain())", "raise ValueError(Plain(), 3)",
                     "raise KeyError(Plain())", "raise ValueError([Plain()])"):  # fmt: skip
            text = error_text(raised(code + last))
            assert text.type in ("Mine", "ValueError", "KeyError")
            assert len(str(text)) < 200
            assert text.file == "control.py"


def test_names_of_classes_are_cleaned_and_their_metaclass_is_not_asked():
    code = """
class Meta(type):
    __name__ = property(lambda kind: 1 / 0)
    def mro(kind): return type.mro(kind)
    def __getattribute__(kind, name): raise SystemExit
raise Meta('\\x1b[31m' + 'x' * 10**6, (Exception,), {})('\\x1b')
"""
    text = error_text(raised(code))
    assert text.type.startswith("\\x1b[31mxxx")
    assert len(text.type) <= 60
    assert text.message == "\\x1b"


@pytest.mark.long
def test_a_message_of_any_length_is_short():
    for code in ("raise ValueError('x' * 10**8)", "raise ValueError(b'x' * 10**7)",
                 "raise ValueError(10**4000)", "raise KeyError('x' * 10**7)",
                 "raise ValueError(['x' * 10**8])", "raise ValueError(*range(10**6))",
                 "raise OSError(2, 'x' * 10**7, 'y' * 10**7)"):  # fmt: skip
        assert len(error_text(raised(code)).message) <= 4000, code


def test_an_ordinary_exception_says_what_python_says():
    for code, message in (
        ("{}['gain']", "'gain'"),
        ("open('not_there')", "[Errno 2] No such file or directory: 'not_there'"),
        ("raise ValueError('a', 3)", "('a', 3)"),
        ("raise ValueError", ""),
        ("def f(): f()\nf()", "maximum recursion"),
        ("compile('x = (', 'control.py', 'exec')", "'(' was never closed"),
    ):
        assert error_text(raised(code)).message.startswith(message)


def test_slot_step_and_the_students_own_lines():
    code = (
        "def control(step):\n    return helper(step.k)\n\n\ndef helper(k): return 1 / (k - 2), 1\n"
    )
    names = {}
    exec(compile(code, "s999/control.py", "exec"), names)
    with pytest.raises(ZeroDivisionError) as caught:
        robsim.Simulation(control=names["control"]).run(5)
    text = error_text(caught.value)
    assert str(text).startswith("control at step 2, control.py, line 5: ZeroDivisionError: ")
    assert (text.slot, text.step, text.file, text.line) == ("control", 2, "control.py", 5)
    assert [line for line in text.lines if "control.py" in line] == [
        "control.py, line 2 in control",
        "control.py, line 5 in helper",
    ]
    error = text.as_error()
    assert (error.slot, error.step, error.file, error.line) == ("control", 2, "control.py", 5)
    assert str(error) == str(text)


def test_a_text_comes_through_the_wire():
    text = error_text(raised("raise ValueError('\\u4e2d' * 10**5)"), slot="control", step=7)
    data = text.to_json()
    assert len(data) <= 16 * 1024
    assert ErrorText.from_json(data) == text
    own = error_text(SubmissionError("s001: \x1b", slot="control", step=3, file="a", line=4))
    assert str(own) == "s001: \\x1b"
    assert ErrorText.from_json(own.to_json()) == own
    for broken in (b"", b"[" * 10_000, b"\xff", b"x" * 20_000, b"3", b"[]"):
        with pytest.raises(ValueError, match="an error must"):
            ErrorText.from_json(broken)
    for sign in '"\\\U0001f600':
        data = ErrorText("ValueError", sign * 4000, (sign * 200,) * 10, "control", 3).to_json()
        assert 8 * 1024 < len(data) <= 16 * 1024
        assert ErrorText.from_json(data).message.startswith(sign * 1000)


FIELDS = st.sampled_from(["type", "message", "lines", "slot", "step", "file", "line"])
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters()),
    lambda inner: st.lists(inner) | st.dictionaries(FIELDS, inner),
)


@pytest.mark.long
@settings(max_examples=25)
@given(st.dictionaries(FIELDS, ANYTHING) | ANYTHING)
def test_whatever_a_worker_tells_is_cleaned(value):
    data = json.dumps(value).encode()
    if not isinstance(value, dict) or len(data) > 16 * 1024:
        with pytest.raises(ValueError, match="an error must "):
            ErrorText.from_json(data)
        return
    text = ErrorText.from_json(data)
    assert harmless(str(text))
    assert all(map(harmless, text.lines))
    assert text.step is None or text.step >= 0


def test_an_error_says_whose_fault_it_is_and_where_beyond_a_process_too():
    for kind in (SubmissionError, AssignmentError, GraderError):
        error = kind("control.py is a link", slot="control", step=3, file="control.py", line=4)
        again = pickle.loads(pickle.dumps(error))
        assert isinstance(again, GradingError)
        assert type(again) is kind
        assert again.whose == kind.__name__.removesuffix("Error").lower()
        assert again.message == str(again) == "control.py is a link"
        assert (again.slot, again.step, again.file, again.line) == ("control", 3, "control.py", 4)
