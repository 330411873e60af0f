"""Files that take the most of their readers, by kind: how each is made and read."""

from __future__ import annotations

import json
import sqlite3
import zipfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import robsim
from robsim.campaigns import campaign
from robsim.teach import Submission
from robsim.trace import Session
from robsim.trace.sessions._setup import setup_text
from robsim.vision import load_image, save_video
from robsim.vision.imaging.images import Pixels, png_bytes
from sessions import write_file

Rng = np.random.Generator
MB = 2**20
_SIDE = 8192  # px of the largest picture


def _trace(path: Path, info: Callable[[dict[str, Any]], str], rows: int = 3) -> None:
    """Save a trace of zeros with another text."""
    robsim.Simulation(seed=1).run(3).save(path)
    with np.load(path) as whole:
        record = json.loads(str(whole["info"]))
        arrays = {
            name: np.zeros((rows, *array.shape[1:]), array.dtype)
            for name, array in whole.items()
            if name != "info"
        }
    np.savez_compressed(path, info=np.array(info(record)), **arrays)


def trace_text(path: Path, rng: Rng) -> None:
    many = ",".join(f'"{key:x}":[]' for key in rng.permutation(130_000))
    _trace(path, lambda record: json.dumps(record)[:-1] + f',"faults":{{{many}}}}}')


def trace_arrays(path: Path, rng: Rng) -> None:
    _trace(path, json.dumps, rows=(255 * MB) // 48)


def toml_keys(path: Path, rng: Rng) -> None:
    path.write_text("x = [" + ",".join(f"{n}" for n in rng.integers(9, size=99_000)) + "]\n")


def toml_tables(path: Path, rng: Rng) -> None:
    keys = rng.permutation(45_000)
    path.write_text("".join(f"[{key:x}]\na=1\n" for key in keys))


def _black() -> Pixels:
    return np.zeros((_SIDE, _SIDE, 3), np.uint8)


def toml_picture(path: Path, rng: Rng) -> None:
    robsim.Scenario(background=_black()).save(path)


def picture(kind: str) -> Callable[[Path, Rng], None]:
    def make(path: Path, rng: Rng) -> None:
        color = tuple(rng.integers(256, size=3).tolist())
        options = {"progressive": True, "subsampling": 0} if kind == "JPEG" else {}
        Image.new("RGB", (_SIDE, _SIDE), color).save(path, kind, **options)

    return make


def sixteen_bits(path: Path, rng: Rng) -> None:
    Image.fromarray(np.full((_SIDE, _SIDE), rng.integers(9999), np.uint16)).save(path, "PNG")


def video(path: Path, rng: Rng) -> None:
    save_video(path, [_black()], fps=5)


_SETUP = setup_text({"area": (300, 300), "dt": 0.2, "robot": "lab"}, kind="PNG")


def session_rows(path: Path, rng: Rng) -> None:
    steps = [(b'{"k":%d,"t":%d}' % (k, k), None) for k in range(200_000)]
    write_file(path, _SETUP, steps, each=len(steps))


def session_cut(path: Path, rng: Rng) -> None:
    write_file(path, _SETUP, [(b'{"k":%d,"t":0}' % k, None) for k in range(50_000)])
    path.write_bytes(path.read_bytes()[:-9])


def session_records(path: Path, rng: Rng) -> None:
    write_file(path, _SETUP, [(b'{"k":0,"t":0}', None)])
    whole = path.read_bytes()
    place = whole.index(b"\x0f\x04\0\0\0\0\0\0\0")  # the end of the data
    path.write_bytes(whole[:place] + b"\xff\0\0\0\0\0\0\0\0" * (20 * MB // 9))


def session_frame(path: Path, rng: Rng) -> None:
    write_file(path, _SETUP, [(b'{"k":0,"t":0}', png_bytes(_black()))])


def _campaign(path: Path) -> Any:
    return campaign(metrics="pose_errors", runs=2, steps=3, store=path, seed=1, progress=False)


_ENDLESS = """
ALTER TABLE campaign RENAME TO there;
CREATE VIEW campaign AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c)
SELECT x AS key, x AS value FROM c
"""


def store_view(path: Path, rng: Rng) -> None:
    _campaign(path)
    _changed(path, _ENDLESS)


def store_text(path: Path, rng: Rng) -> None:
    _campaign(path)
    _changed(path, f"UPDATE campaign SET value = '[{'[],' * 7 * MB}1]'")


def _changed(path: Path, sql: str) -> None:
    with closing(sqlite3.connect(path)) as database:
        database.executescript(sql)


def submission_archive(path: Path, rng: Rng) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("control.py", "def control(step):\n    return 0, 0\n")
        for k in range(4):
            archive.writestr(f"{k}.csv", bytes(rng.integers(2, size=MB, dtype=np.uint8)))
        for k in range(1900):
            archive.writestr(f"{k}/", "")


def submission_code(path: Path, rng: Rng) -> None:
    numbers = ",".join(map(str, rng.integers(9, size=120_000)))
    path.mkdir()
    path.joinpath("control.py").write_text(f"x = [{numbers}]\ndef control(step):\n    return x\n")


def submission_notebook(path: Path, rng: Rng) -> None:
    cell = {"cell_type": "code", "metadata": {}, "outputs": [], "execution_count": None}
    sources = [["%matplotlib inline\n", *["x = [[]]\n"] * 4] for _ in range(999)]
    sources.append(["def control(step):\n", "    return 0, 0\n"])
    cells = [cell | {"source": source} for source in sources]
    notebook = {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}
    path.write_text(json.dumps(notebook))


def _submission(path: Path) -> object:
    return Submission(path, slots="control")


def _frames(path: Path) -> object:
    return sum(1 for _ in robsim.Recording(path, dt=0.1))


def _steps(path: Path) -> object:
    return sum(1 for _ in Session(path))


Case = tuple[str, Callable[[Path, Rng], None], Callable[[Path], object]]

#: The name of the file, how it is made, and how it is read, by the fault in it.
WORST: dict[str, Case] = {
    "trace, text": ("a.npz", trace_text, robsim.Trace.load),
    "trace, arrays": ("a.npz", trace_arrays, robsim.Trace.load),
    "TOML, keys": ("a.toml", toml_keys, robsim.Scenario.load),
    "TOML, tables": ("a.toml", toml_tables, robsim.load_colors),
    "TOML, picture": ("a.toml", toml_picture, robsim.Scenario.load),
    "picture, PNG": ("a.png", picture("PNG"), load_image),
    "picture, 16 bits": ("a.png", sixteen_bits, load_image),
    "picture, JPEG": ("a.jpg", picture("JPEG"), load_image),
    "picture, WebP": ("a.webp", picture("WEBP"), load_image),
    "picture, JPEG 2000": ("a.jp2", picture("JPEG2000"), load_image),
    "video": ("a.mkv", video, _frames),
    "session, steps": ("a.mcap", session_rows, _steps),
    "session, cut": ("a.mcap", session_cut, _steps),
    "session, records": ("a.mcap", session_records, _steps),
    "session, a frame": ("a.mcap", session_frame, _steps),
    "store, view": ("a.db", store_view, _campaign),
    "store, text": ("a.db", store_text, _campaign),
    "submission, zip": ("a.zip", submission_archive, _submission),
    "submission, code": ("a", submission_code, _submission),
    "submission, notebook": ("a.ipynb", submission_notebook, _submission),
}
