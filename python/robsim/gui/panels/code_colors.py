"""The colours of Python code: which part of a line is a keyword, a text, a comment."""

from __future__ import annotations

import builtins
import io
import keyword
import tokenize

_KINDS = {
    tokenize.COMMENT: "comment",
    tokenize.STRING: "string",
    tokenize.NUMBER: "number",
    **{
        getattr(tokenize, name): "string"
        for name in ("FSTRING_START", "FSTRING_MIDDLE", "FSTRING_END")
        if hasattr(tokenize, name)
    },
}
_BUILTINS = {name for name in dir(builtins) if name.islower()}


def code_colors(code: str) -> list[list[tuple[int, int, str]]]:
    """Return the parts (first, end, kind) of each line, as far as the code can be read."""
    lines: list[list[tuple[int, int, str]]] = [[] for _ in code.split("\n")]
    defines = False
    try:
        for token in tokenize.generate_tokens(io.StringIO(code).readline):
            kind = "name" if defines else _kind_of(token)
            defines = token.string in ("def", "class")
            (row, first), (last, end) = token.start, token.end
            for line in range(row, last + 1) if kind else ():
                ends = end if line == last else len(token.line) + len(code)
                lines[line - 1].append((first if line == row else 0, ends, kind))
    except (tokenize.TokenError, SyntaxError, IndexError):  # while it is being written
        pass
    return lines


def _kind_of(token: tokenize.TokenInfo) -> str:
    if token.type == tokenize.NAME and keyword.iskeyword(token.string):
        return "keyword"
    if token.type == tokenize.NAME and token.string in _BUILTINS:
        return "builtin"
    return _KINDS.get(token.type, "")
