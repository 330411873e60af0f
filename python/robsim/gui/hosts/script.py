"""The module for the browser: the files of `static`, joined into one.

Each file is an ES module, for editors and linters. A notebook loads the module from a blob, from
where nothing can be imported: so the files are joined, with their imports left out. Their
top-level names are unique.
"""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

STATIC = Path(__file__).resolve().parents[1] / "static"

_IMPORT = re.compile(r'^import [^;]*? from "([\w/.-]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?!default)", re.MULTILINE)


@functools.cache
def script() -> str:
    """Return the module, which has a default export for anywidget."""
    parts: dict[Path, str] = {}
    _collect(STATIC / "view.js", parts)
    texts = (STATIC / "texts.json").read_text("utf-8")
    return f"const TEXTS = {texts.strip()};\n" + "\n".join(parts.values())


def words(name: str, **values: object) -> str:
    return _texts()[name].format(**values)


@functools.cache
def _texts() -> dict[str, str]:
    texts: dict[str, str] = json.loads((STATIC / "texts.json").read_text("utf-8"))
    return texts


@functools.cache
def style() -> str:
    return "\n".join(file.read_text("utf-8") for file in sorted(STATIC.rglob("*.css")))


def page_script() -> str:
    return (STATIC / "page.js").read_text("utf-8")


def _collect(file: Path, parts: dict[Path, str]) -> None:
    """Add a file, after those that it imports."""
    if file in parts:
        return
    text = file.read_text("utf-8")
    parts[file] = ""  # keeps out of a circle
    for match in _IMPORT.finditer(text):
        _collect((file.parent / match[1]).resolve(), parts)
    del parts[file]
    parts[file] = _EXPORT.sub("", _IMPORT.sub("", text))
