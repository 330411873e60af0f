"""The texts of the panel: all in one file."""

import json
import re

from robsim.gui._hosts.script import STATIC

TEXTS = json.loads((STATIC / "texts.json").read_text("utf-8"))
CODE = {file.name: file.read_text("utf-8") for file in STATIC.rglob("*.js")}


def test_every_text_that_is_asked_for_is_there():
    asked = {
        (file, name)
        for file, code in CODE.items()
        for name in re.findall(r'\b(?:text|makeButton)\(\s*"([^"]+)"(?!, \{\}, )', code)
    }
    assert len(asked) > 50
    assert {(file, name) for file, name in asked if name not in TEXTS} == set()


def test_names_that_are_made_up_begin_as_texts_do():
    made = {
        (file, start)
        for file, code in CODE.items()
        for start in re.findall(r"\btext\(\s*`([\w.]+\.)\$\{", code)
    }
    assert {one for one in made if not any(name.startswith(one[1]) for name in TEXTS)} == set()
