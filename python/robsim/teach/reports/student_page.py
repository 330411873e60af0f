"""The page of a student: points, and for each test a sentence, a picture and what helps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from robsim.teach.reports import words
from robsim.teach.reports.drawings import scale_of
from robsim.teach.reports.markup import Html, data_uri, joined, listed, page, preformatted, tag
from robsim.teach.results import (
    PARTIAL,
    PASSED,
    ScoreResult,
    SubmissionResult,
    TestResult,
    fraction_of,
    number,
)

_HIDDEN = (
    "This test is hidden: its worlds are not given out before or after. To see a run of it, ask "
    "your teacher, who can repeat each one."
)
_FOR_TEACHER = "For the teacher: with hidden tests. Students get index.html."
_SCALE = "Bars: green = all points, red = none; the line is the result, dots are single runs."


def student_page(
    result: SubmissionResult, pictures: Mapping[str, bytes], *, for_teacher: bool = False
) -> str:
    """Return the page as HTML, with PNG files by test; `for_student` makes a student's result."""
    cards = [
        _card(result, test, index, pictures.get(test.name) if test.picture else None, for_teacher)
        for index, test in enumerate(result.tests, 1)
    ]
    body = [_head(result, for_teacher), _overview(result), tag("main", *cards), _foot(result)]
    return page(f"{words.person(result.student)}: {result.title}", tag("div", *body, class_="page"))


def _head(result: SubmissionResult, for_teacher: bool) -> Html:
    points, most = result.points, result.most
    share = 100 * fraction_of(points, most)
    waiting = "" if result.is_done else "Not all tests have been run yet."
    notes = [waiting, words.not_graded(result), *words.notes(result)]
    total = tag("b", number(points)), tag("span", f" of {number(most)} points")
    return tag(
        "header",
        tag("p", result.title, class_="over"),
        tag("h1", words.person(result.student)),
        tag("p", *total, class_="total"),
        tag("div", tag("i", style=f"width:{share:.2f}%"), class_="meter", aria_hidden="true"),
        tag("p", _FOR_TEACHER) if for_teacher else "",
        *(tag("p", note, class_="note") for note in notes if note),
    )


def _overview(result: SubmissionResult) -> Html:
    rows = [
        tag(
            "tr",
            tag("td", tag("a", words.test_title(test), href=f"#test-{index}")),
            tag("td", _pill(test)),
            tag("td", words.result_text(test), class_="right"),
        )
        for index, test in enumerate(result.tests, 1)
    ]
    titles = [tag("th", text, scope="col") for text in ("Test", "Result")]
    head = tag("tr", *titles, tag("th", "Points", scope="col", class_="right"))
    caption = tag("caption", "All tests", class_="unseen")
    return tag("table", caption, tag("thead", head), tag("tbody", *rows), class_="overview")


def _pill(test: TestResult) -> Html:
    word, sign = words.STATUS.get(test.status, (test.status, ""))
    kind = {PASSED: "all", PARTIAL: "some"}.get(test.status, "none")
    return tag("span", tag("span", sign, aria_hidden="true"), f" {word}", class_=f"pill {kind}")


def _card(
    result: SubmissionResult, test: TestResult, index: int, picture: bytes | None, for_teacher: bool
) -> Html:
    points = tag("span", words.result_text(test), class_="points")
    kind = "public" if test.public else "hidden"
    sentence = words.sentence(result, test)
    parts = [
        tag("h2", words.test_title(test), id=f"test-{index}"),
        tag("p", _pill(test), points, tag("span", kind, class_="quiet"), class_="line"),
        tag("p", sentence, class_="sentence") if sentence else "",
        tag("p", words.blame(test), class_="note") if words.blame(test) else "",
        *_scores(test),
        _figure(test, picture),
        *(_box(head, body) for head, body in boxes(test)),
        _repeat(result, test, for_teacher),
    ]
    return tag("section", *parts, class_="card", aria_labelledby=f"test-{index}")


def _scores(test: TestResult) -> list[Html]:
    if not words.has_numbers(test):
        return []
    return [*(_score(score, test) for score in test.scores), tag("p", _SCALE, class_="quiet")]


def _score(score: ScoreResult, test: TestResult) -> Html:
    gives = tag("span", words.points_text(score, test.most), class_="points")
    title = tag("p", tag("b", score.title), gives, class_="line")
    return tag("div", title, tag("p", words.score_text(score)), scale_of(score), class_="score")


def _figure(test: TestResult, picture: bytes | None) -> Html:
    caption = words.caption_text(test)
    if picture is None:
        return tag("p", caption, class_="quiet") if caption and test.picture is None else Html("")
    image = tag("img", src=data_uri(picture), alt=caption or "A run")
    return tag("figure", image, tag("figcaption", caption) if caption else "")


def boxes(test: TestResult) -> Iterator[tuple[str, Html]]:
    """Yield what helps to find a mistake: a heading, and what stands below it."""
    if test.finding:
        yield words.FINDING, preformatted(test.finding)
    if test.failed:
        yield words.failed_head(test), listed(words.failed_texts(test))
    if output := test.output.rstrip():
        yield words.OUTPUT, preformatted(output)


def _box(head: str, body: Html) -> Html:
    if head == words.OUTPUT:  # which may be long
        return tag("details", tag("summary", head), body)
    return tag("div", tag("h3", head), body, class_="box")


def _repeat(result: SubmissionResult, test: TestResult, for_teacher: bool) -> Html:
    if for_teacher and test.runs:
        command = tag("code", words.play_command(result, test))
        return tag("p", "To do a run again: ", command, class_="quiet")
    if not test.public:
        return tag("p", _HIDDEN, class_="quiet")
    command = tag("code", words.repeat_command(test))
    return tag("p", f"{words.REPEAT}: ", command, class_="quiet")


def _foot(result: SubmissionResult) -> Html:
    facts = {
        "Isolation": words.isolation_text(result),
        "Graded with": words.versions_text(result),
        "Handed in": _digest(result.submission_digest),
        "Assignment": f"{result.assignment} {_digest(result.assignment_digest)}".strip(),
        "Took": f"{result.seconds:.1f} s" if result.seconds else "",
    }
    rows = [joined(tag("dt", key), tag("dd", text)) for key, text in facts.items() if text]
    return tag("footer", tag("dl", *rows))


def _digest(digest: str) -> str:
    return f"SHA-256 {digest[:16]}" if digest else ""
