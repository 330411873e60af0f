"""The sources of the site: files of the repository, and pages made from the program itself."""

import os
import re
from pathlib import Path

import reference

ROOT = Path(__file__).parents[3]
NOTEBOOKS = ROOT / "notebooks"
SITE = NOTEBOOKS / "site"
PACKAGE = ROOT / "python/robsim"
PROJECT = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")


def places():
    """Return the place in the site of each file of the repository that is in it."""
    found = {}
    for file in sorted(SITE.rglob("*")):
        inside = file.relative_to(SITE)
        if file.is_file() and not inside.parts[0].startswith("_") and file.suffix != ".py":
            found[file] = inside
    for file in [*NOTEBOOKS.glob("*.ipynb"), *NOTEBOOKS.glob("*.svg")]:
        found[file] = Path("notebooks") / file.name
    for name in PROJECT:
        found[ROOT / name] = Path("project") / name
    for name in ("ARCHITECTURE.md", "PROTOCOL.md"):
        for file in PACKAGE.rglob(name):
            found[file] = Path("project") / file.relative_to(PACKAGE)
    return found


def with_links(text, file, where, folder):
    """Return the text of a file with links that are right at its place in the site."""
    here = (folder / where[file]).parent

    def moved(link):
        target = (file.parent / link[2]).resolve()
        if "://" in link[2] or not target.exists():
            return link[0]
        to = folder / where[target] if target in where else target
        return link[1] + Path(os.path.relpath(to, here)).as_posix()

    return re.sub(r"(\]\()([^)#\s]+)", moved, text)


def gather(folder):
    """Write all sources into a folder. Files without a change keep their times for Sphinx."""
    where = places()
    pages = dict(reference.pages())
    for file, place in where.items():
        data = file.read_bytes()
        if file.suffix in (".md", ".ipynb"):
            data = with_links(data.decode(), file, where, folder).encode()
        pages[place] = data
    for place, data in pages.items():
        path = folder / place
        if not path.exists() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
    for path in folder.rglob("*"):
        is_page = path.is_file() and path.parent != folder / reference.OBJECTS
        if is_page and path.relative_to(folder) not in pages:
            path.unlink()
