"""The site for assistants: `llms.txt`, a line for each page, and `llms-full.txt`, all text."""

import inspect
import json
import re
from importlib.metadata import metadata
from pathlib import Path

from docutils import nodes

import robsim

HEAD = f"# robsim\n\n> {metadata('robsim')['Summary']}\n"
LONGEST = 200  # characters of a description


def write(app, error):
    """Write both files beside the pages, after a build."""
    if error is not None or app.builder.format != "html":
        return
    pages = [one for one in in_order(app.env) if not one.startswith("reference/api/")]
    objects = sorted(one for one in app.env.found_docs if one.startswith("reference/api/"))
    lines = [HEAD, "## Pages\n", *(line_of(app.env, one) for one in pages)]
    lines += ["\n## Python\n", *(line_of(app.env, one) for one in objects)]
    (app.outdir / "llms.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    texts = [HEAD, *(text_of(app, one) for one in pages)]
    texts += ["# Python\n", *(docstrings(Path(one).name) for one in objects)]
    (app.outdir / "llms-full.txt").write_text("\n\n".join(texts) + "\n", encoding="utf-8")


def in_order(env, name="index", found=None):
    """Return the names of pages in the order of the tables of contents."""
    found = {} if found is None else found
    if name not in found:
        found[name] = None
        for child in env.toctree_includes.get(name, ()):
            in_order(env, child, found)
    return list(found)


def line_of(env, name):
    """Return the link to a page, and its first sentence."""
    title = env.titles[name].astext()
    paragraphs = env.get_doctree(name).findall(nodes.paragraph)
    text = next((text for one in paragraphs if len(text := one.astext()) > 20), "")
    sentence = re.match(r".{20,}?[.!?:](?= |$)|.*", " ".join(text.split()))[0].rstrip(":.")
    if len(sentence) > LONGEST:
        sentence = sentence[:LONGEST].rpartition(" ")[0] + " ..."
    return f"- [{title}]({name}.html): {sentence}" if sentence else f"- [{title}]({name}.html)"


def text_of(app, name):
    """Return the source of a page: Markdown, without outputs of cells."""
    file = Path(app.env.doc2path(name))
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        parts = ["".join(cell["source"]) for cell in cells]
        is_code = [cell["cell_type"] == "code" for cell in cells]
        parts = [
            f"```python\n{part}\n```" if code else part
            for part, code in zip(parts, is_code, strict=True)
        ]
        text = "\n\n".join(parts)
    tables = app.config.myst_substitutions
    return re.sub(r"\{\{ (\w+) \}\}", lambda found: tables.get(found[1], found[0]), text)


def docstrings(name):
    """Return the docstring of a public object; a class also has its methods."""
    value = robsim
    for part in name.split(".")[1:]:
        value = getattr(value, part)
    parts = [f"## {name}{signature(value)}\n\n{inspect.getdoc(value)}"]
    for member in sorted(vars(value)) if isinstance(value, type) else ():
        one = getattr(value, member)
        if not member.startswith("_") and (inspect.isroutine(one) or isinstance(one, property)):
            parts.append(f"### {name}.{member}{signature(one)}\n\n{inspect.getdoc(one)}")
    return "\n\n".join(parts)


def signature(value):
    """Return the signature of an object, empty without a signature."""
    try:
        return str(inspect.signature(value)) if callable(value) else ""
    except (TypeError, ValueError):
        return ""
