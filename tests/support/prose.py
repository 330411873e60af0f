"""The README and the pages of the site: their programs, and the lines of their shells."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
SITE = ROOT / "notebooks/site"
PAGES = sorted(SITE.glob("*.md"))


def blocks(page, language="python"):
    """Return the blocks of a page in a language."""
    pattern = rf"^```{language}\n(.*?)^```"
    return re.findall(pattern, page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def page(name):
    return (SITE / f"{name}.md").read_text(encoding="utf-8")


def examples(name):
    """Return the example files of a page by their names, which stand above them."""
    found = re.findall(r"^`([\w./]+)`:\n\n```\w+\n(.*?)^```", page(name), re.DOTALL | re.MULTILINE)
    return dict(found)
