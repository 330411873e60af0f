"""Pages by the templates beside this module: each text in a template is cleaned and escaped."""

from __future__ import annotations

import base64
import hashlib
import statistics
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from robsim.base.checks import Floats
from robsim.teach.reports import words
from robsim.teach.reports.drawings import counts_of, floor_of, scale_of, shade
from robsim.teach.reports.similarity import SimilarPair
from robsim.teach.results import ERROR, NOT_RUN, SubmissionResult, fraction_of, number
from robsim.teach.texts import clean_text

if TYPE_CHECKING:
    from jinja2 import Environment

#: The best run of a student in a test, (N, 2), in px of the work area.
Paths = Mapping[str, Mapping[str, Floats]]

_TEMPLATES = Path(__file__).parent / "templates"


@cache
def _environment() -> Environment:
    import jinja2  # here, since only pages need it

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_harmless,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    functions = (counts_of, data_uri, fraction_of, number, scale_of, shade)
    environment.globals |= {function.__name__: function for function in functions}
    environment.globals |= {"words": words, "mean": statistics.fmean, "median": statistics.median}
    environment.filters["test_title"] = words.test_title
    return environment


def _harmless(value: object) -> object:
    """Return a value as harmless text, to be escaped; markup is only from here and templates."""
    is_harmless = isinstance(value, (int, float)) or hasattr(value, "__html__")
    return value if is_harmless else clean_text(str(value), 2**20)


def rendered(template: str, **values: Any) -> str:
    """Return a template with values in it."""
    return _environment().get_template(template).render(values)


def _page(template: str, script: str = "", **values: Any) -> str:
    """Return a page that needs no other file, and runs only its script of this package."""
    code = (_TEMPLATES / script).read_text("utf-8") if script else ""
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode("ascii")
    values["script_source"] = f"'sha256-{digest}'" if code else "'none'"
    style = (_TEMPLATES / "style.css").read_text("utf-8")
    return rendered(template, style=_markup(style), script=_markup(code), **values)


def _markup(text: str) -> str:
    from markupsafe import Markup

    return Markup(text)


def data_uri(png: bytes) -> str:
    return _markup("data:image/png;base64," + base64.b64encode(png).decode("ascii"))


def student_page(
    result: SubmissionResult, pictures: Mapping[str, bytes], *, for_teacher: bool = False
) -> str:
    """Return the page as HTML, with PNG files by test; `for_student` makes a student's result."""
    return _page("student.html", result=result, pictures=pictures, for_teacher=for_teacher)


def class_page(
    results: Sequence[SubmissionResult],
    *,
    paths: Paths | None = None,
    area: tuple[float, float] = (1200.0, 1200.0),
    pairs: Sequence[SimilarPair] | None = None,
    links: Mapping[str, str] | None = None,
) -> str:
    """Return the page as HTML.

    `paths` lie on the floor `area`. `links` lead to the pages of students, relative to this page.
    Without a comparison of programs `pairs` is None.
    """
    tests = {test.name: test for result in results[::-1] for test in result.tests}
    columns = []
    for name, test in tests.items():
        of = {r.student: one for r in results for one in r.tests if one.name == name}
        graded = {who: one for who, one in of.items() if one.status not in (ERROR, NOT_RUN)}
        short = [who for who, one in graded.items() if one.points < one.most]
        columns.append(
            {
                "test": test,
                "of": of,
                "graded": graded,
                "short": sorted(short, key=lambda who: (graded[who].points, who)),
                "floor": floor_of((paths or {}).get(name, {}), of, area),
            }
        )
    return _page(
        "class.html",
        "class.js",
        results=results,
        columns=columns,
        area=area,
        near={r.student for r in results if any(map(words.is_near, r.tests))},
        isolations=sorted({words.isolation_text(each) for each in results} - {""}),
        pairs=pairs,
        links={name: quote(link, errors="surrogatepass") for name, link in (links or {}).items()},
    )
