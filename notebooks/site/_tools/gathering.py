"""The sources of the site: files of the repository, and pages made from the program itself."""

import os
import re
from pathlib import Path

import reference

ROOT = Path(__file__).parents[3]
SOURCES = (  # a folder, its files, and their folder in the site
    ("notebooks/site", "**/*.md", ""),
    ("notebooks", "*.ipynb", "notebooks"),
    ("", "C*.md", "project"),
    ("", "RELEASING.md", "project"),
    ("", "SECURITY.md", "project"),
    ("python/robsim", "**/ARCHITECTURE.md", "project"),
    ("python/robsim", "DECISIONS.md", "project"),
    ("python/robsim", "NEW_ROOM.md", "project"),
    ("python/robsim", "**/PROTOCOL.md", "project"),
)


def places():
    """Return the place in the site of each file."""
    return {
        file: Path(place) / file.relative_to(ROOT / folder)
        for folder, pattern, place in SOURCES
        for file in (ROOT / folder).glob(pattern)
    }


def with_links(text, file, where, site):
    """Return the text of a file with links that are right at its place in the site."""

    def moved(link):
        target = (file.parent / link[2]).resolve()
        if "://" in link[2] or not target.exists():
            return link[0]
        to = site / where[target] if target in where else target
        return link[1] + Path(os.path.relpath(to, (site / where[file]).parent)).as_posix()

    return re.sub(r"(\]\()([^)#\s]+)", moved, text)


def gather(site):
    """Write all sources into a folder. Files without a change keep their times for Sphinx."""
    where = places()
    pages = dict(reference.pages())
    for file, place in where.items():
        data = file.read_bytes()
        if file.suffix in (".md", ".ipynb"):
            data = with_links(data.decode(), file, where, site).encode()
        pages[place] = data
    for place, data in pages.items():
        path = site / place
        if not path.exists() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
