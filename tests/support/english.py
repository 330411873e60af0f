"""Check the rule of English (CONTRIBUTING.md) in new prose: `python english.py [COMMIT]`.

Prose is a comment, a docstring, a message, a page or a notebook. A line is new if it was added
since COMMIT and if no line with the same text was removed: a move adds nothing. Old prose follows
with the next change of its file. The check reads files in WHOLE completely.
"""

import io
import json
import re
import subprocess
import sys
import tokenize
from collections import Counter, defaultdict

SINCE = "678fb27c95ada42d10afe5f9d286775e2f8811b1"
LONGEST = 25  # words
LEFT_OUT = ("tests/data", "CHANGELOG", "tests/support/english.py", "tests/package/test_english.py")
SUFFIXES = ("py", "md", "ipynb", "js", "cpp", "hpp", "css", "texts.json")
WHOLE = r"[A-Z_]+\.md|notebooks/|cpp/bindings/|python/(?!robsim/gui/static/.*(js|css)$)"
CLAUSE = r"(a|an|the|it|they|is|was|are|were|has|have|must|may|can|comes|belongs|needs|makes|lies)"
FORBIDDEN = {  # what must not stand there: what to write
    r"\b(whoever|whichever|whatever|nobody|somebody|anybody else)\b": "a named component",
    r"^(who|what|that of|those|one of|nothing that|none) [a-z]+ (?!.*\?)": "a named subject",
    rf"(?<!just )\bwhat {CLAUSE}\b(?!.*\?)": "a noun",
    r"\b(that|those) of (the|its|their|a|an|ours|theirs|others)\b": "a short noun",
    r"\bthe (one|ones|line|frame|value|time|run) before\b": "previous",
    r"\b(asks?|asked) for\b": "request, require, option",
    r"\b(is|are|was|were|be|been) told\b": "receives, knows",
    r"\btells? (which|whether|what|of|it)\b": "reports",
    r"\b(says?|said) (so|it|itself|what|which|whether|of)\b": "reports, names",
    r"\b(anew|once more)\b": "again, rerun",
    r"\b(by itself|of its own|of their own|of ours|of theirs)\b": "alone, separate, own",
    r"\bthat (there )?(is|are) (not|none)\b": "unknown, missing",
    r"\b(there|has|have|had|is|are) (?-i:none)\b": "no, missing, empty",
    r"\b(no|not|nothing|none)\b.* any ?more\b": "no longer",
    r"\b(as yet|for ever|ever after|hitherto|thereby|whence|wherein|whereof)\b": "yet, always, so",
    r"\b(is|are|looks?) (ill|amiss)\b": "fails, is wrong",
    r"\bin (the )?place of\b": "instead of",
    r"\b(such as it|so it does|so they do|as it does)\b": "a second sentence",
    r"\bis (given|handed) to (whom|who)\b": "goes to",
    r"\bcome(s)? of\b": "results from",
    r"\bcannot be had\b": "is unavailable",
    r"\bcan ?not (help|do) (but|without)\b": "requires",
    r"\b(beside|besides) (it|that|them)\b": "next to, also",
    r"\bbefore (it|them)\b(?=[.;:,)]|$)": "previous, first",
    r"\b(comes|stands|lies) (to be )?there\b": "is there",
    r"\b(ere|lest|albeit|thus far|aforesaid|upon)\b": "before, so that, although, on",
    r"\bare (well|all well)\b": "pass",
    r"\bmend(s|ed|ing)?\b": "repair, fix",
    r"\bhears? of\b": "receives",
    r"\b(without|with) (it|them)\b(?=[.;:,)]|$)": "a named component",
    r"\bas (long|often|many|much) as (it|they) (takes?|likes?|wants?)\b": "a condition",
    r"\b(leaves?|left) (it|them) (be|alone)\b": "ignores, keeps",
    r"\bgoes? on\b": "continues",
    r"\btwo of (them|these|those)\b": "a noun",
    r"\bof which\b": "a second sentence",
    r"\bdoes away with\b": "removes",
    r"\b(make|makes|made) (it|that|this) so\b": "a named effect",
    r"\bno such thing\b": "unknown",
    r"\b(first|last) thing to\b": "first, last",
    r"; [^='{]*; |: .*; .*: ": "one colon or semicolon at most",
}


def git(*arguments):
    """Return the output of Git."""
    command = ["git", *arguments]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, encoding="utf-8").stdout


def new_lines(since):
    """Return the numbers of new lines by file."""
    diff = git("diff", "-U0", "--no-color", "--no-ext-diff", since, "--")
    removed = Counter(line[1:].strip() for line in diff.splitlines() if re.match("-(?!--)", line))
    added, file, number = defaultdict(set), "", 0
    for line in diff.splitlines():
        if line.startswith("+++ "):
            file = line.removeprefix("+++ b/")
        elif found := re.match(r"@@ .*\+(\d+)", line):
            number = int(found[1])
        elif line.startswith("+"):
            text = line[1:].strip()
            if removed[text]:
                removed[text] -= 1
            else:
                added[file].add(number)
            number += 1
    return added


def prose(file, text):
    """Yield each line of prose with its number; code in it is left out."""
    if file.endswith(".ipynb"):
        cells = r'"cell_type": "(\w+)".*?"source": \[\n(.*?)\n *\]'
        for cell in re.finditer(cells, text, re.DOTALL):
            before = text.count("\n", 0, cell.start(2))
            source = "".join(json.loads(f"[{cell[2]}]"))
            for number, line in prose({"markdown": ".md", "code": ".py"}[cell[1]], source):
                yield before + number, line
        return
    if file.endswith(".py"):
        kinds = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", None)}
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type in kinds:
                end = "" if token.string.startswith(("#", '"""')) else "."
                for number, line in enumerate(token.string.splitlines(), token.start[0]):
                    yield number, line.strip("#\"' \t") + end
        return
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if file.endswith(".md"):
            fenced ^= line.startswith("```") or line.count("$$") == 1
            if not fenced:
                end = "." if "|" in line else ""
                yield from ((number, cell.strip(" #*-") + end) for cell in line.split("|"))
        else:
            line = re.sub(r'"\w+"_a', "", line)  # the name of an argument
            for *comment, string in re.findall(r'//+ (.*)|^\s*/?\*+ (.*)|"([^"]*)"', line):
                if string.count(" ") > 1 or any(comment):
                    yield number, "".join((*comment, string)) + "." * file.endswith(".json")


def faults(file, text, new):
    """Yield the number of each new line that breaks the rule, and why."""
    words, start = 0, 0
    for number, line in prose(file, text):
        line = re.sub(r"`[^`]*`|\$[^$]+\$|\([^)]*\)|https?:\S+|^what(?= must be)", "X", line)
        if number in new:
            for pattern, remedy in FORBIDDEN.items():
                if found := re.search(pattern, line, re.IGNORECASE):
                    yield number, f"{found[0]!r}: write {remedy}"
        words = words if number - start <= 1 and line and not line.startswith(("|", ">>>")) else 0
        start = number
        for word in line.split():
            words += 1
            if words == LONGEST + 1 and number in new:
                yield number, f"a sentence has more than {LONGEST} words"
            if word.rstrip("*_)\"'").endswith((".", "!", "?", ":", ";", "|")):
                words = 0


def main(since):
    """Print all faults; return whether there are any."""
    shallow = git("rev-parse", "--is-shallow-repository").strip() == "true"
    if shallow:
        print("english: left out, the clone is shallow")
        return False
    found = False
    lines = new_lines(since)
    lines |= {file: range(10**9) for file in git("ls-files").splitlines() if re.match(WHOLE, file)}
    for file, new in sorted(lines.items()):
        if file.endswith(SUFFIXES) and not file.startswith(LEFT_OUT):
            with open(file, encoding="utf-8") as opened:
                for number, fault in faults(file, opened.read(), new):
                    print(f"{file}:{number}: {fault}")
                    found = True
    return found


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:] or [SINCE]))
