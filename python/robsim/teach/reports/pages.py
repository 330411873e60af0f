"""Pages from the templates next to this module, which cleans and escapes each text."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import chain
from statistics import fmean, median
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from robsim.base.checks import Floats
from robsim.teach.reports import words
from robsim.teach.reports.drawings import counts_of, paths_of, scale_of, shade, view_of
from robsim.teach.reports.similarity import Comparison
from robsim.teach.results import ERROR, NOT_RUN, SubmissionResult, fraction_of, number
from robsim.teach.texts import clean_text

if TYPE_CHECKING:
    from jinja2 import Environment

#: The best run of a student in a test, (N, 2), in px of the work area.
Paths = Mapping[str, Mapping[str, Floats]]


@cache
def _environment() -> Environment:
    import jinja2  # here, because only pages need it

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(__package__),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_harmless,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["words"] = words
    drawing = (counts_of, digest, scale_of, shade, view_of)
    plain = (fmean, fraction_of, median, number, quote, zip)
    environment.globals |= {function.__name__: function for function in (*drawing, *plain)}
    environment.filters |= {name: one for name, one in vars(words).items() if callable(one)}
    return environment


def _harmless(value: object) -> object:
    """Return numbers and markup unchanged, all else as clean text, which jinja2 escapes."""
    is_harmless = isinstance(value, (int, float)) or hasattr(value, "__html__")
    return value if is_harmless else clean_text(str(value), 2**20)


def rendered(template: str, **values: Any) -> str:
    return _environment().get_template(template).render(values)


def digest(script: str) -> str:
    """Return the SHA-256 of a script as a Content-Security-Policy names it."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def data_uri(png: bytes) -> str:
    from markupsafe import Markup

    return Markup("data:image/png;base64," + base64.b64encode(png).decode("ascii"))


def student_page(
    result: SubmissionResult, pictures: Mapping[str, bytes], *, for_teacher: bool = False
) -> str:
    """Return the page as HTML, with PNG files by test; `for_student` makes a student's result."""
    shown = {name: data_uri(png) for name, png in pictures.items()}
    return rendered("student.html", result=result, pictures=shown, for_teacher=for_teacher)


def class_page(
    results: Sequence[SubmissionResult],
    *,
    paths: Paths | None = None,
    area: tuple[float, float] = (1200.0, 1200.0),
    found: Comparison | None = None,
    links: Mapping[str, str] | None = None,
) -> str:
    """Return the page as HTML.

    `paths` lie on the floor `area`. `links` lead to the pages of students, relative to this page.
    Without a comparison of programs `found` is None.
    """
    columns = []
    for name, test in {test.name: test for r in results[::-1] for test in r.tests}.items():
        of = {r.student: one for r in results for one in r.tests if one.name == name}
        graded = {who: one for who, one in of.items() if one.status not in (ERROR, NOT_RUN)}
        short = sorted((one.points, who) for who, one in graded.items() if one.points < one.most)
        drawn = paths_of((paths or {}).get(name, {}), of)
        column = {"test": test, "of": of, "graded": graded, "short": short, "paths": drawn}
        columns.append(column | {"title": words.test_title(test)})
    near = {result.student for result in results if any(map(words.is_near, result.tests))}
    alike = set() if found is None else {*chain(*found.alike)}
    values = {"results": results, "columns": columns, "near": near, "area": area, "found": found}
    return rendered("class.html", **values, links=links or {}, alike=alike)
