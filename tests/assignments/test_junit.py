"""JUnit's XML, by the rules of its schema."""

from xml.etree import ElementTree

from graded_results import graded, hidden, submission
from robsim.assignments._reports import junit_xml

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


def test_it_keeps_to_the_schema():
    check_element(ElementTree.fromstring(junit_xml([])))
    tests = [
        graded("a", status="passed", points=4.0),
        graded("b"),
        graded("c", status="error", whose="grader"),
        graded("d", status="not run"),
        hidden(),
    ]
    results = [submission("s001", tests), submission("müller <&>", tests[:2])]
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
    assert "run 7: estimate_state at step 17" in first[2].find("failure").text
