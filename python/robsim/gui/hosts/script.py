"""The browser's module: the files of `static`, joined into one.

Each file is an ES module, for editors and linters. A notebook loads the module from a blob,
which cannot import files. So the files are joined: each becomes a function with its scope,
which returns its exports. Circular imports are impossible.
"""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

STATIC = Path(__file__).resolve().parents[1] / "static"

_IMPORT = re.compile(r'^import ({[^;]*?}) from "([\w/.-]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:class|const|function) (\w+))", re.MULTILINE)
_DEFAULT = "export default "  # in view.js, for anywidget


@functools.cache
def script() -> str:
    """Return the module, with a default export for anywidget."""
    parts: dict[Path, str] = {}
    first = STATIC / "view.js"
    _collect(first, parts)
    texts = (STATIC / "texts.json").read_text("utf-8").strip()
    code = "\n".join(parts.values())
    return f"const TEXTS = {texts};\n{code}\nexport default {_scope(first)}.byDefault;\n"


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
    """Add a file, after its imports."""
    if file in parts:
        return
    text = file.read_text("utf-8")
    for match in _IMPORT.finditer(text):
        _collect(_imported(file, match), parts)
    names = _EXPORT.findall(text)
    if _DEFAULT in text:
        names.append("byDefault")
    code = _IMPORT.sub(lambda one: f"const {one[1]} = {_scope(_imported(file, one))};\n", text)
    code = _EXPORT.sub("", code).replace(_DEFAULT, "const byDefault = ")
    parts[file] = (
        f"const {_scope(file)} = (() => {{\n{code}return {{ {', '.join(names)} }};\n}})();\n"
    )


def _imported(file: Path, match: re.Match[str]) -> Path:
    return (file.parent / match[2]).resolve()


def _scope(file: Path) -> str:
    """Return the variable with the exports of a file, such as ``charts_axis``."""
    return "_".join(file.relative_to(STATIC).with_suffix("").parts)
