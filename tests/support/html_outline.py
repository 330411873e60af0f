"""The outline of a page: its elements and its text, by Python's own parser."""

from html.parser import HTMLParser

_VOID = {"img", "meta", "br", "input"}


class Outline(HTMLParser):
    """What a page has; an element that is not closed in its place is an error."""

    def __init__(self, page):
        super().__init__(convert_charrefs=True)
        self.elements, self._open, self._texts = [], [], []
        self.feed(page)
        self.close()
        assert self._open == [], self._open

    @property
    def text(self):
        """All that is text, but for styles and scripts."""
        return "".join(self._texts)

    @property
    def names(self):
        return [name for name, _ in self.elements]

    def attributes(self, name):
        """Return the values of all attributes of this name."""
        return [found[name] for _, found in self.elements if name in found]

    def handle_starttag(self, name, attributes):
        assert len(dict(attributes)) == len(attributes), (name, attributes)
        self.elements.append((name, dict(attributes)))
        if name not in _VOID:
            self._open.append(name)

    def handle_startendtag(self, name, attributes):
        self.elements.append((name, dict(attributes)))

    def handle_endtag(self, name):
        assert self._open.pop() == name, name

    def handle_data(self, data):
        if not {"style", "script"} & set(self._open):
            self._texts.append(data)

    def handle_comment(self, data):
        raise AssertionError(data)

    def handle_pi(self, data):
        raise AssertionError(data)
