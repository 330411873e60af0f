"""Check for `./run release` versions, placeholders, and the README and licences of wheels.

`python check_release.py [--rehearse] [WHEEL...]`; with --extras it prints the names of the extras.
"""

import email
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
LICENCES = {"LICENSE", "Eigen-MPL-2.0.txt", "pybind11-BSD-3-Clause.txt"}


def text(name):
    """Return the text of a file of the project."""
    return (ROOT / name).read_text(encoding="utf-8")


def project():
    """Return the table `project` of pyproject.toml."""
    return tomllib.loads(text("pyproject.toml"))["project"]


def faults_of_tree(rehearse):
    """Yield each fault of versions; for a release also blanks of the owner and open changes."""
    version = project()["version"]
    if f"\nversion: {version}\n" not in text("CITATION.cff"):
        yield f"CITATION.cff: expected version: {version}, as in pyproject.toml"
    newest = re.search(r"^## (\S+?)(?:,| - )(.*)", text("CHANGELOG.md"), re.MULTILINE)
    if newest[1] != version:
        yield f"CHANGELOG.md: expected {version} as newest version, got {newest[1]}"
    if rehearse:
        return
    if changed := subprocess.check_output(["git", "status", "--porcelain"], cwd=ROOT, text=True):
        yield f"the tree has changes that no commit has:\n{changed}"
    if not re.fullmatch(r"\d{4}-\d\d-\d\d", newest[2]):
        yield f"CHANGELOG.md: expected '## {version} - YYYY-MM-DD', got '{newest[0]}'"
    for number, line in enumerate(text("pyproject.toml").splitlines(), 1):
        if "OWNER" in line.replace("each OWNER", ""):
            yield f"pyproject.toml:{number}: the owner has to fill in {line.strip()}"


def faults_of_wheel(path):
    """Yield each relative or broken link of a wheel's README, and each missing licence."""
    with zipfile.ZipFile(path) as wheel:
        names = wheel.namelist()
        metadata = next(name for name in names if name.endswith(".dist-info/METADATA"))
        message = email.message_from_bytes(wheel.read(metadata))
    readme = message.get_payload(decode=True).decode()
    for link in re.findall(r"\]\(([^)]*)\)", readme):
        if not link.startswith("https://"):
            yield f"{path}: the README links to {link}: expected an absolute address"
        elif not (ROOT / link.partition(f"/v{message['Version']}/")[2]).exists():
            yield f"{path}: the README links to {link}: no such file in the project"
    licences = {Path(name).name for name in names if "/licenses/" in name}
    yield from (f"{path}: without licence {name}" for name in LICENCES - licences)


def main(arguments):
    """Print all faults; return their number."""
    if arguments == ["--extras"]:
        print(*project()["optional-dependencies"])
        return 0
    rehearse, wheels = "--rehearse" in arguments, [one for one in arguments if one[0] != "-"]
    faults = [*faults_of_tree(rehearse)]
    for wheel in wheels:
        faults += faults_of_wheel(wheel)
    print(*faults, sep="\n", end="\n" if faults else "")
    return len(faults)


if __name__ == "__main__":
    sys.exit(min(main(sys.argv[1:]), 1))
