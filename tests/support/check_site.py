"""Check the built site: `python check_site.py FOLDER`.

Each internal link has its target, also in llms.txt, and no page loads anything from the internet.
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADS = ("script", "img", "iframe", "source", "video", "embed", "object")
STYLES = ("stylesheet", "preload", "modulepreload", "icon", "preconnect")


class Page(HTMLParser):
    """The links of a page, its anchors, and all addresses from which it loads."""

    def __init__(self, file):
        super().__init__()
        self.links, self.anchors, self.loaded = [], set(), []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors |= {given[key] for key in ("id", "name") if given.get(key)}
        address = given.get("href") or given.get("src") or given.get("data")
        if not address:
            return
        self.links.append(address)
        if tag in LOADS or (tag == "link" and set(given.get("rel", "").split()) & {*STYLES}):
            self.loaded.append(address)


def faults(folder):
    """Yield a line for each fault."""
    files = [file.resolve() for file in sorted(folder.rglob("*.html"))]
    pages = {file: Page(file) for file in files if "_static" not in file.parts}
    for file, page in pages.items():
        for address in page.loaded:
            if re.match(r"(\w+:)?//", address):
                yield f"{file}: loads {address}"
        for address in page.links:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            anchors = pages[target].anchors if target in pages else ()
            if not target.exists():
                yield f"{file}: no file {address}"
            elif parts.fragment and target in pages and unquote(parts.fragment) not in anchors:
                yield f"{file}: no anchor {address}"
    for file in folder.glob("llms.txt"):
        for address in re.findall(r"^- \[.*?\]\((.+?)\)", file.read_text(), re.MULTILINE):
            if not (folder / address).exists():
                yield f"{file}: no file {address}"
    for file in folder.rglob("*.css"):
        for address in re.findall(r"(?:url\(|@import )[\"']?(https?://[^\"')]+)", file.read_text()):
            yield f"{file}: loads {address}"


if __name__ == "__main__":
    found = list(faults(Path(sys.argv[1])))
    sys.exit("\n".join(found) if found else 0)
