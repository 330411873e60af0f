"""The SQLite file of a campaign: what is in it, what is refused, what is left after an end."""

import functools
import json
import os
import re
import sqlite3
import struct
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import robsim
from campaign_code import Faster, final, run_of, steady
from robsim.campaigns import campaign
from surroundings import full_disk

PAGE = 4096  # bytes, in SQLite

SCENARIO = robsim.Scenario(area=(300, 300), start="random", control=robsim.DriveAround())


def run(store=None, **options):
    given = {"metrics": [final], "runs": 10, "steps": 10, "seed": 3, "progress": False, **options}
    given.setdefault("vary", {"motor_delay": [0, 1.5]})
    return campaign(given.pop("scenario", SCENARIO), store=store, **given)


@pytest.fixture
def store(tmp_path):
    return tmp_path / "store.sqlite"


def rows_in(store, query="SELECT * FROM results ORDER BY case_id, run"):
    with closing(sqlite3.connect(store)) as database:
        return database.execute(query).fetchall()


def count_runs(monkeypatch):
    """A list that gets an entry for each run that is done."""
    done = []
    monkeypatch.setattr(
        "robsim.campaigns.runs.numbers_of",
        lambda metrics, trace, taken: done.append(1) or {"final_x": 0.0},
    )
    return done


def test_any_client_can_read_the_rows(store):
    result = run(store)
    query = "SELECT motor_delay, error, line, seconds, final_x FROM results ORDER BY case_id, run"
    rows = rows_in(store, query)
    assert [row[0] for row in rows] == result["motor_delay"].tolist()
    assert [row[-1] for row in rows] == result["final_x"].tolist()
    assert [file.name for file in store.parent.iterdir()] == ["store.sqlite"]


def test_the_same_call_again_runs_nothing_with_the_seed_of_its_store(store, monkeypatch):
    first = run(store, seed=None)
    assert run(seed=first.spec.seed).checksum == first.checksum
    done = count_runs(monkeypatch)
    assert run(store, seed=None).checksum == first.checksum
    assert not done


def test_more_runs_are_added_and_fewer_are_chosen(store, monkeypatch):
    few, all_at_once = run(store, runs=4), run(runs=10)
    assert run(store, runs=10).checksum == all_at_once.checksum
    assert run(store, runs=4).checksum == few.checksum
    done = count_runs(monkeypatch)
    run(store, runs=11)
    assert len(done) == 2


def test_a_campaign_that_was_ended_goes_on(store):
    def interrupt(trace):
        if run_of(trace) == 7 and not goes_on:
            raise KeyboardInterrupt
        return trace.pose_true[-1, 0]

    goes_on = False
    with pytest.raises(KeyboardInterrupt) as caught:
        run(store, metrics=[interrupt])
    left = len(rows_in(store))
    assert 0 < left < 10
    assert caught.value.__notes__ == [
        f"{store} has {left} of 20 runs: the same call continues with the others"
    ]
    goes_on = True
    assert run(store, metrics=[interrupt]).checksum == run(metrics=[interrupt]).checksum


def test_another_campaign_is_refused(store):
    run(store)
    before = store.read_bytes()
    for other, message in (
        ({"steps": 11}, "steps is 10 there, 11 here"),
        ({"seed": 4}, "seed"),
        ({"vary": {"motor_delay": {0: 0, 1.5: 1.6}}}, "value"),
        ({"scenario": SCENARIO.replace(boundary="unlimited")}, "scenario"),
        ({"metrics": [final, run_of]}, "run_of"),
    ):
        with pytest.raises(ValueError, match=f"another campaign.*{message}"):
            run(store, **other)
        assert store.read_bytes() == before


def test_other_code_is_refused(store, tmp_path):
    (tmp_path / "mine").mkdir()
    control = tmp_path / "mine/control.py"
    control.write_text("def control(step):\n    return 0.5, 0.4\n")
    vary = {"control": {"fresh": Faster, "plain": steady, "folder": tmp_path / "mine"}}
    run(store, vary=vary)
    run(store, vary=vary)
    control.write_text("def control(step):\n    return 0.5, 0.3\n")
    with pytest.raises(ValueError, match="control 'folder'"):
        run(store, vary=vary)
    vary["control"] = {**vary["control"], "fresh": steady}
    with pytest.raises(ValueError, match="control 'fresh'"):
        run(store, vary=vary)


def test_a_store_of_another_version_goes_on_with_a_warning(store, monkeypatch):
    first = run(store, runs=2)
    monkeypatch.setattr("robsim.campaigns._store.surroundings", lambda: {"numpy": "9.9"})
    with pytest.warns(UserWarning, match=r"created with numpy .*, here is '9\.9'"):
        assert run(store, runs=2).checksum == first.checksum


def test_what_is_no_store_is_refused(store):
    store.write_text("some text that is longer than the header of a database" * 100)
    with pytest.raises(OSError, match="not a database"):
        run(store)
    store.write_bytes(b"")
    run(store)  # begins it
    store.unlink()
    rows_in(store, "CREATE TABLE mine (x)")
    for seed in (1, None):
        with pytest.raises(ValueError, match="not the store"):
            run(store, seed=seed)


@pytest.mark.long
def test_a_page_that_was_not_written_is_found_or_holds_nothing(store):
    def many(trace):
        return dict.fromkeys(map(str, range(20)), run_of(trace))

    options = {"metrics": [many], "vary": {"motor_delay": [0]}, "steps": 1}
    expected = run(store, runs=20, keep="traces", **options).trace(0, 7)
    checksum = run(store, runs=200, **options).checksum
    content = store.read_bytes()
    refusals, traces_refused, opened = [], 0, 0
    for begin in range(0, len(content), PAGE):
        store.write_bytes(content[:begin] + bytes(PAGE) + content[begin + PAGE :])
        try:
            result = run(store, runs=200, **options)
        except (ValueError, OSError) as error:
            refusals.append(str(error))
            continue
        assert result.checksum == checksum
        opened += 1
        try:
            assert result.trace(0, 7) == expected
        except (ValueError, OSError):
            traces_refused += 1
    store.write_bytes(content[: len(content) // 2])
    with pytest.raises((ValueError, OSError), match=r"damaged|malformed"):
        run(store, runs=200, **options)
    assert opened > traces_refused > 0
    assert refusals
    assert [text for text in refusals if not re.search(r"damaged|malformed|not a dat", text)] == []


def without_shared_memory(path, connect=sqlite3.connect, **options):
    """Connect as on a file system that has none, so that there can be no WAL."""
    return connect(f"{Path(path).as_uri()}?vfs=unix-dotfile", uri=True, **options)


@pytest.mark.skipif(sys.platform == "win32", reason="a file system of SQLite for POSIX")
def test_where_the_file_system_allows_no_wal_there_is_a_journal(store, monkeypatch):
    def metric(trace):
        beside.update(file.name for file in store.parent.iterdir())
        return final(trace)

    beside = set()
    expected = run(store, metrics=[metric]).checksum
    assert "store.sqlite-wal" in beside
    store.unlink()
    beside.clear()
    monkeypatch.setattr("robsim.campaigns._store.sqlite3.connect", without_shared_memory)
    assert run(store, metrics=[metric], runs=4, on_error="raise")
    assert "store.sqlite-wal" not in beside
    assert run(store, metrics=[metric]).checksum == expected
    monkeypatch.undo()
    assert run(store, metrics=[metric]).checksum == expected
    assert [file.name for file in store.parent.iterdir()] == ["store.sqlite"]


@pytest.mark.long
def test_a_disk_that_fills_up_leaves_what_is_there(store):
    expected = run(runs=500).checksum
    with (
        full_disk(150_000),
        pytest.raises(OSError, match=r"store\.sqlite: .*(full|disk)") as caught,
    ):
        run(store, runs=500, keep="traces")
    assert any("the same call continues" in note for note in caught.value.__notes__)
    assert rows_in(store)
    assert run(store, runs=500).checksum == expected


def test_two_programs_with_one_store_do_each_run_once(store):
    def metric(trace):
        if run_of(trace) == 3 and not is_begun:
            is_begun.append(True)
            others.append(run(store, metrics=[metric]))  # as if from another program
        return {"x": 1, "y": run_of(trace)}

    is_begun, others = [], []
    result = run(store, metrics=[metric])
    assert result.checksum == others[0].checksum
    assert not result.failed.any()
    assert len(rows_in(store)) == 20


def test_numbers_come_back_as_they_were(store):
    def strange(trace):
        odd = {"odd": 1} if run_of(trace) % 2 else {}
        return {"inf": np.inf, "tiny": 5e-324, "third": 1 / 3, "zero": -0.0} | odd

    metrics = {"m": strange, "M": lambda trace: 1, "m_Inf": lambda trace: 2, "none": lambda t: None}
    result = run(store, metrics=metrics, runs=2)
    assert run(store, metrics=metrics, runs=2).checksum == result.checksum
    assert run(metrics=metrics, runs=2).checksum == result.checksum
    np.testing.assert_array_equal(np.isnan(result["m_odd"]), result["run"] % 2 == 0)
    assert result["m_inf"][0] == np.inf
    assert result["m_tiny"][0] == 5e-324
    assert (result["M"][0], result["m_Inf"][0]) == (1, 2)
    assert np.isnan(result["none"][0])


# --- traces


def no_run(monkeypatch):
    def refuse(self, run):
        raise AssertionError("the run was done again")

    monkeypatch.setattr("robsim.campaigns.runs.CaseRuns.trace", refuse)


@pytest.mark.parametrize("executor", [None, pytest.param(2, marks=pytest.mark.long)])
def test_traces_are_read_from_the_store(store, monkeypatch, executor):
    scenario = SCENARIO.replace(measure=True, resolution=(240, 240))
    result = run(store, scenario=scenario, keep="traces", executor=executor, runs=3)
    assert result.checksum == run(scenario=scenario, runs=3).checksum
    again = run(scenario=scenario, runs=3).trace({"motor_delay": 1.5}, 2)
    no_run(monkeypatch)
    monkeypatch.chdir("/")
    assert result.trace({"motor_delay": 1.5}, 2) == again
    assert run(store, scenario=scenario, runs=3).trace(1, 2).info == again.info


def test_runs_without_a_kept_trace_are_done_again(store, monkeypatch):
    run(store, runs=2)
    result = run(store, runs=3, keep="traces")
    expected = [run(runs=3).trace(0, number) for number in range(3)]
    assert [result.trace(0, number) for number in range(3)] == expected
    no_run(monkeypatch)
    assert result.trace(0, 2) == expected[2]
    with pytest.raises(AssertionError, match="done again"):
        result.trace(0, 1)
    store.unlink()
    with pytest.raises(AssertionError, match="done again"):
        result.trace(0, 2)
    assert not store.exists()


def test_a_trace_of_another_campaign_is_not_taken(store):
    result = run(store, keep="traces", runs=1)
    store.unlink()
    run(store, keep="traces", runs=1, seed=4)
    assert result.trace(0, 0) == run(runs=1).trace(0, 0)


def test_a_damaged_trace_is_named(store):
    result = run(store, keep="traces", runs=1)
    with closing(sqlite3.connect(store)) as database, database:
        database.execute("UPDATE traces SET trace = zeroblob(500)")
    with pytest.raises(ValueError, match=r"store\.sqlite: run 0 of case 1 is not a robsim trace"):
        result.trace(1, 0)


def test_arguments_of_a_metric_are_told_to_the_last_number(store):
    square = [(float(x), float(y)) for x in range(20) for y in range(20)]
    score = functools.partial(robsim.score_path, waypoints=np.array(square))
    there = run(store, metrics=[score]).checksum
    same = functools.partial(robsim.score_path, waypoints=np.array(square))
    assert run(store, metrics=[same]).checksum == there
    square[200] = (10.0, 0.5)
    for other in (np.array(square), square):
        with pytest.raises(ValueError, match="score_path"):
            run(store, metrics=[functools.partial(robsim.score_path, waypoints=other)])


def test_a_run_that_did_not_come_to_its_end_has_no_trace(store):
    def fails(of):
        raise ValueError("it always does")

    vary = {"control": {"good": steady, "bad": fails}}
    run(store, keep="traces", vary=vary, metrics=[fails], runs=1)  # good: a metric alone failed
    assert rows_in(store, "SELECT case_id, run FROM traces") == [(0, 0)]


def test_traces_need_a_file():
    for keep in ("traces", "trace"):
        with pytest.raises(ValueError, match="keep"):
            run(keep=keep)


def test_programs_that_begin_one_store_at_once_all_go_on(store, tmp_path):
    program = """
import pathlib, sys, time
import robsim
from robsim.campaigns import campaign
scenario = robsim.Scenario(area=(300, 300))
pathlib.Path(sys.argv[1]).touch()
while len(list(pathlib.Path().glob("ready-*"))) < 3:
    time.sleep(0.001)
result = campaign(scenario, store="store.sqlite", metrics="pose_errors", runs=8, steps=5,
                  progress=False)
print(result.checksum)
"""
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", program, f"ready-{i}"],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for i in range(3)
    ]
    ended = [process.communicate(timeout=300) for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], ended
    assert len({out for out, _ in ended}) == 1  # with one seed, though none was given


def change(store, script):
    with closing(sqlite3.connect(store)) as database:
        database.executescript(script)


def changed_schema(table, old, new):
    return (
        "PRAGMA writable_schema = ON; UPDATE sqlite_master "
        f"SET sql = replace(sql, '{old}', '{new}') WHERE name = '{table}'"
    )


@pytest.mark.parametrize(
    "trap",
    [
        "ALTER TABLE campaign RENAME TO there; CREATE VIEW campaign AS WITH RECURSIVE "
        "c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x AS key, x AS value FROM c",
        "CREATE TRIGGER more AFTER INSERT ON runs BEGIN INSERT INTO traces "
        "VALUES (1, 1, zeroblob(900000000)); END",
        "ALTER TABLE campaign ADD COLUMN much AS (hex(zeroblob(400000000)))",
        "CREATE VIRTUAL TABLE traces2 USING fts5(text)",
        "CREATE INDEX more ON runs (hex(zeroblob(run + 100)))",
        "CREATE INDEX more ON runs (run) WHERE length(hex(zeroblob(run + 100))) > 5",
        changed_schema("runs", "error TEXT", "error TEXT CHECK (length(hex(zeroblob(100))) > 5)"),
        changed_schema("campaign", "value TEXT", "value TEXT DEFAULT (hex(zeroblob(100)))"),
        "UPDATE campaign SET value = " + repr("[" * 90_000 + "]" * 90_000),
        """UPDATE campaign SET value = '{"seed": {"a": 5}}' WHERE key = 'description'""",
        """UPDATE campaign SET value = '{"seed": {"entropy": "x"}}' WHERE key = 'description'""",
        "UPDATE campaign SET value = '{}' WHERE key = 'description'",
        "UPDATE runs SET seconds = 'abc'",
        "UPDATE columns SET name = 'mine'",
    ],
)
def test_a_store_that_robsim_has_not_written_is_refused_by_its_name(store, trap):
    run(store, seed=None)
    change(store, trap)
    with pytest.raises(ValueError, match=re.escape(f"store {store}: ")):
        run(store, seed=None)


def test_a_value_of_a_store_has_a_largest_size(store, monkeypatch):
    run(store)
    change(store, "UPDATE campaign SET value = zeroblob(200000) WHERE key = 'format'")
    monkeypatch.setattr("robsim.campaigns._store._MOST_VALUE", 100_000)
    with pytest.raises(OSError, match="too big"):
        run(store)


def test_other_surroundings_are_told_in_one_line(store):
    run(store)
    value = json.dumps({"robsim": "\x1b[31m\n"})
    change(store, f"UPDATE campaign SET value = '{value}' WHERE key = 'surroundings'")
    with pytest.warns(UserWarning, match="created with robsim") as caught:
        run(store)
    assert str(caught[0].message).isprintable()


def hot_journal(store, other):
    """Put a journal beside a store that names another file, which SQLite would delete."""
    other.write_bytes(b"mine\0/nowhere\0")
    name, magic = bytes(other), bytes.fromhex("d9d505f920a163d7")
    head = magic + struct.pack(">5I", 0, 1, store.stat().st_size // PAGE, 512, PAGE)
    end = struct.pack(">I", 2**30 // PAGE + 1) + name + struct.pack(">2I", len(name), sum(name))
    store.with_name(f"{store.name}-journal").write_bytes(head.ljust(512, b"\0") + end + magic)


@pytest.mark.parametrize("is_linked", [False, True])
def test_a_journal_beside_a_store_deletes_no_other_file(store, tmp_path, is_linked):
    result, other = run(store, keep="traces", runs=1), tmp_path / "thesis"
    change(store, "PRAGMA journal_mode = DELETE")
    hot_journal(store, other)
    if is_linked:
        store = tmp_path / "link.sqlite"
        store.symlink_to("store.sqlite")
    for read in (lambda: run(store, runs=2), lambda: result.trace(0, 0)):
        with pytest.raises(ValueError, match="journal"):
            read()
        assert other.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pipes")
@pytest.mark.parametrize("beside", ["", "-journal"])
def test_a_pipe_beside_a_store_is_not_waited_for(store, beside):
    run(store)
    change(store, "PRAGMA journal_mode = DELETE")
    place = store.with_name(store.name + beside)
    place.unlink(missing_ok=True)
    os.mkfifo(place)
    with pytest.raises((ValueError, OSError)):
        run(store)


def test_a_store_in_memory_looks_at_no_file(store, tmp_path, monkeypatch):
    """No file has the name that SQLite gives it; Windows allows no such file."""
    monkeypatch.chdir(tmp_path)
    run(store)
    if sys.platform != "win32":
        hot_journal(store, tmp_path / "thesis")
        Path(f"{store}-journal").rename(":memory:-journal")
    assert run(None)["final_x"].tolist() == run(None)["final_x"].tolist()
