"""The rows of a campaign as files for other programs."""

import csv
import sys

import numpy as np
import pytest

import robsim
from campaign_code import failing_in_some, final
from commands import command

SCENARIO = robsim.Scenario(area=(300, 300), start="random", control=robsim.DriveAround())
SPEC = """
runs = 3
steps = 5
metrics = ["tracking"]
scenario = {measure = true, area = [300, 300]}
vary.motor_delay = [0, 1]
"""


@pytest.fixture(scope="module")
def result():
    vary = {"motor_delay": [0, 1.5], "control": {"slow": robsim.Spin(0.1), "fast": robsim.Spin(1)}}
    metrics = [final, failing_in_some]
    return robsim.campaign(
        SCENARIO, vary=vary, metrics=metrics, runs=5, steps=5, seed=1, progress=False
    )


def test_a_folder_of_npz_has_a_file_for_each_case(result, tmp_path):
    result.to_npz(tmp_path / "rows")
    files = sorted((tmp_path / "rows").iterdir())
    assert [file.name for file in files] == [f"case_00{case}.npz" for case in range(4)]
    for case, file in enumerate(files):
        with np.load(file) as arrays:
            assert set(arrays) == set(result.columns)
            rows = slice(5 * case, 5 * case + 5)
            for name in ("run", "final_x", "failing_in_some", "seconds"):
                np.testing.assert_array_equal(arrays[name], result[name][rows])
            assert arrays["case_id"] == case
            assert arrays["motor_delay"] == (0, 1.5)[case // 2]
            assert arrays["control"] == ("slow", "fast")[case % 2]
            assert arrays["error"][3] == result["error"][5 * case + 3] != ""
            assert arrays["error"][2] == arrays["line"][2] == ""


def test_no_npz_goes_to_files_of_others(result, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="is not empty"):
        result.to_npz(tmp_path)
    with pytest.raises(NotADirectoryError, match="is a file"):
        result.to_npz(tmp_path / "mine.txt")
    assert [file.name for file in tmp_path.iterdir()] == ["mine.txt"]


def test_nothing_is_left_of_npz_that_cannot_be_written(result, tmp_path, monkeypatch):
    def full(file, content):
        if "002" in file.name:
            raise OSError(28, "No space left on device", str(file))
        file.write_bytes(content)

    monkeypatch.setattr("robsim.campaigns.result.write_whole", full)
    with pytest.raises(OSError, match="No space left"):
        result.to_npz(tmp_path / "rows")
    assert not list(tmp_path.iterdir())


def test_parquet_has_all_rows_with_their_types(result, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    result.to_parquet(tmp_path / "rows.parquet")
    table = parquet.read_table(tmp_path / "rows.parquet")
    assert table.column_names == list(result.columns)
    types = {name: str(table.schema.field(name).type) for name in table.column_names}
    assert (types["run"], types["motor_delay"], types["final_x"]) == ("int64", "double", "double")
    assert types["control"] == types["error"] == types["line"] == "string"
    frame = table.to_pydict()
    assert frame["control"] == result["control"].tolist()
    assert frame["error"] == result["error"].tolist()
    numbers = result["failing_in_some"].tolist()
    assert frame["failing_in_some"] == [None if np.isnan(n) else n for n in numbers]


@pytest.mark.long
def test_the_command_exports_and_refuses_before_it_runs(tmp_path, monkeypatch):
    (tmp_path / "few.toml").write_text(SPEC)
    words = ("campaign", "few.toml")
    ended = command(*words, "--csv", "rows.csv", "--npz", "rows", cwd=tmp_path)
    assert ended.exit_code == 0, ended.stderr
    with open(tmp_path / "rows.csv", newline="") as file:
        assert len(list(csv.DictReader(file))) == 6
    assert len(list((tmp_path / "rows").iterdir())) == 2
    assert "rows written to rows.csv" in ended.stdout + ended.stderr
    again = command(*words, "--npz", "rows", "--store", "few.sqlite", cwd=tmp_path)
    assert (again.exit_code, "rows is not empty" in again.stderr) == (2, True)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    none = command(*words, "--parquet", "r.parquet", "--store", "few.sqlite", cwd=tmp_path)
    assert "pip install pyarrow" in none.stderr
    assert none.exit_code
    assert not (tmp_path / "few.sqlite").exists()
