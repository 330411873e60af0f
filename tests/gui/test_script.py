"""The module for the browser, which is joined from files; and its texts."""

import json
import re
import shutil
import subprocess

import pytest

from robsim.gui.hosts.script import STATIC, page_script, script


def test_each_file_has_a_scope_of_its_own():
    files = [file for file in STATIC.rglob("*.js") if file.name != "page.js"]
    top = re.findall(r"^const (\w+) = \(\(\) => {$", script(), re.MULTILINE)
    assert len(set(top)) == len(top) == len(files)
    # Whatever else begins a line is inside one of them.
    outside = re.sub(r"^const \w+ = \(\(\) => {$.*?^}\)\(\);$", "", script(), flags=re.M | re.S)
    names = re.findall(r"^(?:async )?(?:const|let|class|function) (\w+)", outside, re.MULTILINE)
    assert names == ["TEXTS"]


def test_the_module_imports_nothing():
    assert re.findall(r"^(?:import|export (?!default))", script(), re.MULTILINE) == []


def test_no_text_becomes_code_or_elements():
    ways = r"(?:inner|outer)HTML|insertAdjacentHTML|document\.write|srcdoc|\beval\(|new Function"
    handlers = r"setAttribute\(['\"`]on|javascript:"
    code = script() + page_script()
    assert re.findall(f"{ways}|createContextualFragment|parseFromString|{handlers}", code) == []


@pytest.mark.long
def test_node_can_read_it(tmp_path):
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node")
    (tmp_path / "view.mjs").write_text(script(), "utf-8")
    assert subprocess.run([node, "--check", tmp_path / "view.mjs"], check=False).returncode == 0


TEXTS = json.loads((STATIC / "texts.json").read_text("utf-8"))
CODE = {str(file.relative_to(STATIC)): file.read_text("utf-8") for file in STATIC.rglob("*.js")}
#: Functions whose first text is the name of one.
ASKING = r"text|makeButton|makeWords|makeHint|makeAct\(context"


def test_every_text_that_is_asked_for_is_there():
    asked = {
        (file, name)
        for file, code in CODE.items()
        for name in re.findall(rf'\b(?:{ASKING})[(,]\s*"([^"]+)"(?!, \{{\}}, )', code)
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
