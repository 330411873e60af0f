"""The page of a class: who has how many points, how they are spread, paths, similar programs."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from urllib.parse import quote

from robsim.teach.reports import words
from robsim.teach.reports.drawings import histogram, shade
from robsim.teach.reports.markup import Html, page, preformatted, tag
from robsim.teach.reports.similarity import Passage, SimilarPair
from robsim.teach.results import ERROR, NOT_RUN, SubmissionResult, TestResult, number


def class_page(
    results: Sequence[SubmissionResult],
    *,
    floors: Sequence[Html] = (),
    pairs: Sequence[SimilarPair] | None = None,
    links: Mapping[str, str] | None = None,
) -> str:
    """Return the page as HTML.

    `floors` have the best paths, `links` the pages of students, relative to this page. Without a
    comparison of programs `pairs` is None.
    """
    tests = tests_of(results)
    title = results[0].title
    signs = "; ".join(f"{sign} {word}" for word, sign in words.STATUS.values())
    parts = [
        _head(results),
        tag("h2", "Points", id="points"),
        tag("div", *_histograms(results, tests), class_="charts"),
        tag("h2", "Who has what", id="students"),
        tag("div", _table(results, tests, links or {}), class_="scroll"),
        tag("p", f"{signs}.", class_="quiet"),
        tag("h2", "Which tests were hard", id="tests"),
        tag("div", _hardest(results, tests), class_="scroll"),
    ]
    if floors:
        parts += [tag("h2", "Best runs", id="paths"), tag("div", *floors, class_="charts large")]
    if pairs is not None:
        none = [tag("p", "No two programs have a striking part in common.")]
        parts += [tag("h2", "Similar programs", id="similar"), tag("p", words.HINT, class_="note")]
        parts += map(_pair, pairs) if pairs else none
    body = tag("div", *parts, class_="page wide")
    return page(f"{title}: the class", body, script="class.js")


def tests_of(results: Sequence[SubmissionResult]) -> list[TestResult]:
    tests: dict[str, TestResult] = {}
    for result in results:
        for test in result.tests:
            tests.setdefault(test.name, test)
    return list(tests.values())


def _head(results: Sequence[SubmissionResult]) -> Html:
    points = [result.points for result in results]
    most = max(result.most for result in results)
    mean, middle = statistics.fmean(points), statistics.median(points)
    count = f"{len(results)} submission{'' if len(results) == 1 else 's'}"
    text = f"{count}; mean {number(mean)}, median {number(middle)} of {number(most)} points"
    facts = sorted({words.isolation_text(each) for each in results} - {""})
    isolation = [tag("p", f"Isolation: {fact}", class_="quiet") for fact in facts]
    unfinished = sum(not result.is_done for result in results)
    unread = sum(result.is_unread for result in results)
    notes = [f"{unfinished} not graded to the end yet."] if unfinished else []
    notes += [f"{unread} could not be read: the pages of these students say why."] if unread else []
    return tag(
        "header",
        tag("p", "The class", class_="over"),
        tag("h1", results[0].title),
        tag("p", text),
        *isolation,
        *(tag("p", note, class_="note") for note in notes),
    )


def _histograms(results: Sequence[SubmissionResult], tests: Sequence[TestResult]) -> list[Html]:
    most = max(result.most for result in results)
    drawn = [histogram("In all", [result.points for result in results], most)]
    for test in tests:
        graded = (each for _, each in _of_students(results, test))
        points = [each.points for each in graded if each.status not in (ERROR, NOT_RUN)]
        drawn.append(histogram(words.test_title(test), points, test.most))
    return drawn


def _table(
    results: Sequence[SubmissionResult], tests: Sequence[TestResult], links: Mapping[str, str]
) -> Html:
    titles = ["Submission", "Points", *(words.test_title(test) for test in tests), "Seconds"]
    heads = [tag("th", tag("button", title, type="button"), scope="col") for title in titles]
    rows = [_row(result, tests, links.get(result.student)) for result in results]
    caption = tag("caption", "Press a heading to sort by it.")
    body = tag("thead", tag("tr", *heads)), tag("tbody", *rows)
    return tag("table", caption, *body, class_="sortable")


def _row(result: SubmissionResult, tests: Sequence[TestResult], link: str | None) -> Html:
    name: object = words.person(result.student)
    if link is not None:
        name = tag("a", name, href=quote(link, errors="surrogatepass"))
    total = result.points
    graded = {test.name: test for test in result.tests}
    cells = [_cell(graded.get(test.name)) for test in tests]
    return tag(
        "tr",
        tag("th", name, scope="row"),
        tag("td", tag("b", number(total)), data_value=f"{total:.4f}", class_="right"),
        *cells,
        tag("td", f"{result.seconds:.1f}", data_value=f"{result.seconds:.4f}", class_="right"),
    )


def _cell(test: TestResult | None) -> Html:
    if test is None:
        return tag("td", "", data_value="-2")
    word, sign = words.STATUS.get(test.status, (test.status, ""))
    if test.status in (ERROR, NOT_RUN):
        return tag("td", f"{sign} {word}", data_value="-1", class_="cell", title=test.sentence)
    points = test.points
    look = {"class_": f"cell {shade(points, test.most)}", "title": test.sentence or None}
    return tag("td", f"{sign} {number(points)}", data_value=f"{points:.4f}", **look)


def _hardest(results: Sequence[SubmissionResult], tests: Sequence[TestResult]) -> Html:
    rows = [_hard(test, _of_students(results, test)) for test in tests]
    titles = ("Test", "Not all points", "Failed runs", "Without all points")
    heads = [tag("th", title, scope="col") for title in titles]
    caption = tag("caption", "Who failed which", class_="unseen")
    return tag("table", caption, tag("thead", tag("tr", *heads)), tag("tbody", *rows))


def _of_students(
    results: Sequence[SubmissionResult], test: TestResult
) -> list[tuple[str, TestResult]]:
    return [(r.student, each) for r in results for each in r.tests if each.name == test.name]


def _hard(test: TestResult, graded: Sequence[tuple[str, TestResult]]) -> Html:
    short = [
        (student, each)
        for student, each in graded
        if each.status not in (ERROR, NOT_RUN) and each.points < each.most
    ]
    worst_first = sorted(short, key=lambda one: (one[1].points, one[0]))
    names = ", ".join(
        f"{words.person(student)} ({number(each.points)})" for student, each in worst_first
    )
    runs = sum(len(each.failed) for _, each in graded)
    kind = "" if test.public else " (hidden)"
    return tag(
        "tr",
        tag("th", words.test_title(test) + kind, scope="row"),
        tag("td", f"{len(short)} of {len(graded)}", class_="few"),
        tag("td", runs),
        tag("td", names, class_="names"),
    )


def _pair(pair: SimilarPair) -> Html:
    a, b = pair.first, pair.second
    shares = f"{100 * pair.share_of_first:.0f} % of {a}, {100 * pair.share_of_second:.0f} % of {b}"
    summary = tag("summary", tag("b", f"{a} and {b}"), f": {shares}, {pair.lines} lines")
    shown = [
        tag("div", _passage(a, left), _passage(b, right), class_="pair")
        for left, right in pair.passages
    ]
    return tag("details", summary, *shown)


def _passage(student: str, passage: Passage) -> Html:
    place = f"{student}, {passage.file}, lines {passage.first_line} to {passage.last_line}"
    return tag("div", tag("p", place, class_="quiet"), preformatted(passage.text))
