"""JUnit's XML, by its schema's rules and other parsers."""

from xml.etree import ElementTree

import pytest

from graded_results import graded, hidden, submission
from robsim.assignments._reports import junit_xml
from robsim.assignments._results import ERROR, NOT_RUN, PASSED

# Attributes (required first) and children, of Jenkins' schema junit-10.
SCHEMA = {
    "testsuites": ((), ("name", "time", "tests", "failures", "errors"), {"testsuite"}),
    "testsuite": (
        ("name", "tests", "failures", "errors"),
        ("time", "skipped", "timestamp", "hostname", "id", "package", "file", "log", "url"),
        {"properties", "testcase", "system-out", "system-err", "testsuite"},
    ),
    "properties": ((), (), {"property"}),
    "property": (("name", "value"), (), set()),
    "testcase": (
        ("name",),
        ("time", "classname", "group"),
        {"skipped", "error", "failure", "system-out", "system-err"},
    ),
    **dict.fromkeys(("skipped", "error", "failure"), ((), ("type", "message"), set())),
    **dict.fromkeys(("system-out", "system-err"), ((), (), set())),
}


def check_element(element):
    required, more, children = SCHEMA[element.tag]
    assert set(required) <= set(element.attrib) <= {*required, *more}, element.attrib
    assert {child.tag for child in element} <= children
    if "time" in element.attrib:
        assert float(element.attrib["time"]) >= 0
        assert "e" not in element.attrib["time"]
    for child in element:
        check_element(child)


@pytest.fixture
def results():
    tests = [
        graded("a", status=PASSED, points=4.0),
        graded("b"),
        graded("c", status=ERROR, whose="grader"),
        graded("d", status=NOT_RUN),
        hidden(),
    ]
    return [submission("s001", tests), submission("müller <&>", tests[:2])]


def test_it_keeps_to_the_schema(results):
    root = ElementTree.fromstring(junit_xml(results))
    check_element(root)
    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("7", "3", "1")
    first, second = root
    assert [case.find("*").tag for case in first.iter("testcase")] == [
        *("system-out", "failure", "error", "skipped", "failure")
    ]
    assert (first.get("tests"), first.get("skipped")) == ("5", "1")
    assert second.get("name") == "müller <&>"
    properties = {each.get("name"): each.get("value") for each in second.iter("property")}
    assert properties["points"] == "6.92"


def test_a_test_without_all_points_has_failed(results):
    root = ElementTree.fromstring(junit_xml(results))
    failure = root[0][2].find("failure")
    assert failure.get("message").startswith("2.92 of 4 points: The estimate stays behind")
    assert "run 7: estimate_state at step 17" in failure.text


def test_another_parser_reads_it(results, tmp_path):
    junitparser = pytest.importorskip("junitparser")
    file = tmp_path / "junit.xml"
    file.write_bytes(junit_xml(results))
    suites = list(junitparser.JUnitXml.fromfile(str(file)))
    assert [suite.name for suite in suites] == ["s001", "müller <&>"]
    cases = list(suites[0])
    assert [case.is_passed for case in cases] == [True, False, False, False, False]
    assert [case.is_error for case in cases] == [False, False, True, False, False]
    assert cases[3].is_skipped


def test_no_result_is_valid_too():
    check_element(ElementTree.fromstring(junit_xml([])))
