"""Puts the functions of complex numbers in front of Wine's C runtime, which has not got them.

``python complete_runtime.py UCRTBASE.DLL FOLDER``: a library of that name in the folder, beside a
program, has them, and hands all other calls on to a copy of Wine's.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

COMPLEX_FUNCTIONS = Path(__file__).with_name("complex_functions.c")
SIGNATURE = b"Wine builtin DLL"  # Wine looks for what bears it among its own alone


def exported(library: Path) -> list[str]:
    """The names that a library exports."""
    command = ["x86_64-w64-mingw32-objdump", "-p", str(library)]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return re.findall(r"^\s*\[\s*\d+\]\s+(\S+)$", text.partition("[Ordinal/Name Pointer]")[2], re.M)


def definitions(names: list[str]) -> str:
    """A module definition file: our functions by name, and where the others are."""
    text = COMPLEX_FUNCTIONS.read_text()
    own = {*re.findall(r"^(?:COMPLEX|REAL)\((\w+)\)", text, re.M), "cpow"}
    lines = ["LIBRARY ucrtbase.dll", "EXPORTS"]
    for name in names:
        short = name[:-1] if name[-1] in "fl" and name[:-1] in own else name
        if short not in own:
            lines.append(f'"{name}" = "ucrtwine.{name}"')
        else:  # for Microsoft, long double is double
            lines.append(f'"{name}" = "own_{name if name == short + "f" else short}"')
    return "\n".join(lines) + "\n"


def main(library: Path, folder: Path) -> None:
    (folder / "ucrtwine.dll").write_bytes(
        library.read_bytes().replace(SIGNATURE, bytes(len(SIGNATURE)), 1)
    )
    with tempfile.TemporaryDirectory() as scratch:
        exports = Path(scratch, "ucrtbase.def")
        exports.write_text(definitions(exported(library)))
        target = folder / "ucrtbase.dll"
        compiler = ["x86_64-w64-mingw32-gcc", "-O2", "-shared", "-static", "-o", str(target)]
        subprocess.run([*compiler, str(COMPLEX_FUNCTIONS), str(exports)], check=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
