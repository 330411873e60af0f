"""Results of campaigns: summaries and exported files."""

import csv
import sys

import numpy as np
import pytest
from scipy import stats

import robsim
from campaign_code import failing_in_some, final
from commands import command
from robsim.campaigns.summary import summary_of

# --- summaries


def summary(values, level=0.95):
    return summary_of(
        np.asarray(values, float)[..., np.newaxis],
        by=("filter",),
        groups=[f"g{i}" for i in range(len(values))],
        metrics=("error",),
        level=level,
        failed=0,
    )


def test_means_and_intervals_are_those_of_students_t(rng):
    values = rng.normal(3, 2, (2, 12))
    report = summary(values, level=0.9)
    for group in range(2):
        low, high = stats.t.interval(
            0.9, 11, loc=values[group].mean(), scale=stats.sem(values[group])
        )
        assert report.mean[group, 0] - report.half_width[group, 0] == pytest.approx(low)
        assert report.mean[group, 0] + report.half_width[group, 0] == pytest.approx(high)
        assert report.sd[group, 0] == pytest.approx(values[group].std(ddof=1))


def test_means_of_different_runs_are_told(rng):
    values = rng.normal(size=(2, 12))
    same = summary(values)
    values[1, :5] = np.nan
    different = summary(values)
    assert (different.n[1, 0], different.n_pairs[1, 0]) == (7, 7)
    assert len(different.remarks) == len(same.remarks) + 1


def test_differences_are_those_of_pairs(rng):
    common = rng.normal(0, 10, 20)
    values = np.array([common, common + rng.normal(1, 0.5, 20)])
    report = summary(values)
    low, high = stats.ttest_rel(values[1], values[0]).confidence_interval(0.95)
    assert report.difference[1, 0] - report.difference_half_width[1, 0] == pytest.approx(low)
    assert report.difference[1, 0] + report.difference_half_width[1, 0] == pytest.approx(high)
    assert report.more_runs[1, 0] == 0  # decided, though the means' own intervals overlap
    assert report.half_width[0, 0] > report.difference[1, 0]
    assert "decided" in str(report)


def test_so_many_runs_more_decide_and_one_less_does_not(rng):
    difference = rng.normal(0.2, 1.0, 15)
    report = summary([np.zeros(15), difference])
    more = int(report.more_runs[1, 0])
    assert more > 0
    mean, sd = difference.mean(), difference.std(ddof=1)

    def decides(n):
        return abs(mean) > stats.t.ppf(0.975, n - 1) * sd / np.sqrt(n)

    assert decides(15 + more)
    assert not decides(15 + more - 1)


def test_unknown_numbers_do_not_count():
    report = summary([[1, 2, np.nan, 4], [2, np.nan, 3, 6]])
    assert report.n[:, 0].tolist() == [3, 3]
    assert report.n_pairs[:, 0].tolist() == [3, 2]
    assert report.difference[1, 0] == 1.5


def test_too_few_runs_and_no_difference_are_told():
    report = summary([[1.0], [2.0]])
    assert np.isnan(report.half_width).all()
    assert np.isnan(report.more_runs[1, 0])
    assert "-" in str(report)
    same = summary([[1.0, 2, 3], [1.0, 2, 3]])
    assert same.more_runs[1, 0] == np.inf
    assert "no difference" in str(same)
    assert summary([[1.0, 2, 3], [2.0, 3, 4]]).more_runs[1, 0] == 0  # constant, so decided
    nothing = summary(np.full((2, 3), np.nan))
    assert np.isnan(nothing.mean).all()


# --- exported files


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
