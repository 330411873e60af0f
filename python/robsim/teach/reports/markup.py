"""HTML: every text is escaped, unless it is markup already."""

from __future__ import annotations

import base64
import hashlib
import html
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from robsim.teach.texts import clean_text

_VOID = frozenset({"img", "meta", "br", "rect", "line", "circle", "polyline", "path"})
_FILES = Path(__file__).parent


class Html(str):
    """Markup, as `tag` makes it: other text is escaped when it is put into some."""

    __slots__ = ()


def escaped(text: object) -> Html:
    """Return a text as markup: no tag, no control character, nothing that turns the text around."""
    if isinstance(text, Html):
        return text
    return Html(html.escape(clean_text(str(text), 2**20)))


def joined(*parts: object) -> Html:
    return Html("".join(map(escaped, parts)))


def tag(name: str, /, *content: object, **attributes: Any) -> Html:
    """Return an element; texts in its content are escaped.

    Attributes are written with ``_`` for ``-``, ``class_`` for class. None and False omit one.
    """
    given = "".join(
        f" {key.rstrip('_').replace('_', '-')}" + ("" if value is True else f'="{escaped(value)}"')
        for key, value in attributes.items()
        if value is not None and value is not False
    )
    if name in _VOID and not content:
        return Html(f"<{name}{given}>" if name in ("img", "meta", "br") else f"<{name}{given}/>")
    return Html(f"<{name}{given}>{joined(*content)}</{name}>")


def preformatted(text: str) -> Html:
    # The first line break after <pre> is no part of the text.
    return Html(f"<pre>\n{escaped(text)}</pre>")


def listed(texts: Iterable[str]) -> Html:
    items = [tag("li", text) for text in texts]
    return tag("ul", *items) if items else Html("")


def data_uri(png: bytes) -> Html:
    return Html("data:image/png;base64," + base64.b64encode(png).decode("ascii"))


def page(title: str, *body: object, script: str | None = None) -> str:
    """Return a page that needs no other file, and loads only its script of this package."""
    style = (_FILES / "style.css").read_text("utf-8")
    code = (_FILES / script).read_text("utf-8") if script else ""
    head = joined(
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=_policy(code)),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="color-scheme", content="light dark"),
        tag("title", title),
        Html(f"<style>{style}</style>"),
    )
    end = Html(f"<script>{code}</script>" if code else "")
    document = tag("html", tag("head", head), tag("body", *body, end), lang="en")
    return f"<!DOCTYPE html>\n{document}\n"


def _policy(code: str) -> str:
    """Return what a page may load: pictures that stand in it, and its own script."""
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode("ascii")
    script = f"'sha256-{digest}'" if code else "'none'"
    return (
        f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {script}; "
        "base-uri 'none'; form-action 'none'"
    )
