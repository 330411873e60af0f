"""The rows of a campaign: which runs, with which seeds, callbacks and metrics."""

import functools

import numpy as np
import pytest

import robsim
from campaign_code import Faster, failing_in_some, final, run_of, steady
from robsim.campaigns import campaign

SCENARIO = robsim.Scenario(
    area=(300, 300), start="random", control=robsim.DriveAround(), estimate_parameters=True
)
OPTIONS = {"runs": 6, "steps": 20, "seed": 5, "progress": False}


def by_hand(run, **options):
    scenario = SCENARIO.replace(seed=np.random.SeedSequence(5, spawn_key=(run,)))
    return robsim.Simulation(scenario, **options).run(20)


def blobs_seen(trace):
    return {
        "red": float(np.nansum(trace.blobs["red"])),
        "sum": float(np.nansum(trace.pose_measured)) + float(trace.pose_true.sum()),
    }


def test_rows_are_those_of_single_simulations_in_the_order_cases_x_runs():
    vary = {"motor_delay": [0, 1.5], "control": {"mine": Faster, "default": robsim.DriveAround()}}
    result = campaign(SCENARIO, vary=vary, metrics=[final], **OPTIONS)
    assert list(result.columns) == [
        *("case_id", "run", "motor_delay", "control", "final_x", "final_y"),
        *("error", "line", "seconds"),
    ]
    assert len(result) == 24
    for row in range(24):
        case, run = divmod(row, 6)
        delay, control = divmod(case, 2)
        assert (result["case_id"][row], result["run"][row]) == (case, run)
        assert result["motor_delay"][row] == (0, 1.5)[delay]
        assert result["control"][row] == ("mine", "default")[control]
        made = {} if control else {"control": Faster()}
        trace = by_hand(run, motor_delay=(0, 1.5)[delay], **made)
        assert result["final_x"][row] == trace.pose_true[-1, 0]
        assert result["final_y"][row] == trace.pose_true[-1, 1]


def test_cases_of_a_robot_half_see_the_same_frames_drawn_once():
    world = SCENARIO.replace(
        noise=robsim.GaussianNoise(10), dropout=robsim.Dropout(0.3), estimate_parameters=None
    )
    seen = {"plain": [], "again": []}  # frames that are kept are not drawn over

    def looking(frames):
        def measure(step):
            frames.append(step.frame)
            return robsim.locate(step.blobs, step.markers) if step.k % 2 else None

        return lambda: measure

    vary = {
        "measure": {"none": lambda: lambda step: None} | {k: looking(v) for k, v in seen.items()}
    }
    result = campaign(world, vary=vary, metrics=[blobs_seen], **OPTIONS)
    assert set(result["error"]) == {None}
    for first, second in zip(*seen.values(), strict=True):
        assert np.shares_memory(first.image, second.image)
    for name, case in vary["measure"].items():
        alone = campaign(world, vary={"measure": {name: case}}, metrics=[blobs_seen], **OPTIONS)
        rows = result["measure"] == name
        np.testing.assert_array_equal(alone["blobs_seen_sum"], result["blobs_seen_sum"][rows])
        np.testing.assert_array_equal(alone["blobs_seen_red"], result["blobs_seen_red"][rows])
    assert len(set(result["blobs_seen_sum"])) > 6


def test_cases_that_drive_elsewhere_see_their_own_frames():
    controls = {"a": Faster, "b": lambda: steady}
    world = SCENARIO.replace(noise=robsim.GaussianNoise(10), measure=True, estimate_parameters=None)
    both = campaign(world, vary={"control": controls}, metrics="tracking", **OPTIONS)
    for name, control in controls.items():
        alone = campaign(world, vary={"control": {name: control}}, metrics="tracking", **OPTIONS)
        rows = both["control"] == name
        np.testing.assert_array_equal(alone["tracking_rmse_xy"], both["tracking_rmse_xy"][rows])


def test_run_i_has_the_same_seed_in_every_case_and_whatever_the_number_of_runs():
    one = campaign(SCENARIO, metrics=[final], **OPTIONS)
    more = campaign(
        SCENARIO, vary={"camera_delay": [0, 1]}, metrics=[final], **{**OPTIONS, "runs": 9}
    )
    table = more["final_x"].reshape(2, 9)
    np.testing.assert_array_equal(table[0], table[1])  # the robot is blind
    np.testing.assert_array_equal(table[0, :6], one["final_x"])
    assert one.spec.seed_of(3).spawn_key == (3,)
    assert len(set(one["final_x"])) == 6


def test_the_seed_is_that_of_the_scenario_unless_one_is_given():
    of_scenario = campaign(SCENARIO.replace(seed=5), metrics=[final], **{**OPTIONS, "seed": None})
    assert of_scenario.checksum == campaign(SCENARIO, metrics=[final], **OPTIONS).checksum
    unseeded = campaign(SCENARIO, metrics=[final], **{**OPTIONS, "seed": None})
    again = campaign(SCENARIO, metrics=[final], **{**OPTIONS, "seed": unseeded.spec.seed})
    assert again.checksum == unseeded.checksum != of_scenario.checksum


def test_metrics_are_names_functions_and_reports():
    waypoints = [(150, 150), (200, 200)]
    metrics = {
        "tracking": "tracking",
        "path": functools.partial(robsim.score_path, waypoints=waypoints),
        "one": run_of,
        "batch": "batch",
        "pose_errors": "pose_errors",
        "nees": "nees",
    }

    def make():
        return lambda step: robsim.Estimate((150, 150, 0), np.diag((1e4, 1e4, 1)))

    vary = {"estimate_state": {"constant": make}}
    result = campaign(SCENARIO.replace(measure=True), vary=vary, metrics=metrics, **OPTIONS)
    trace = result.trace({"estimate_state": "constant"}, 2)
    assert result["tracking_rmse_xy"][2] == trace.tracking().rmse_xy
    assert result["path_rmse"][2] == robsim.score_path(trace, waypoints).rmse
    assert result["one"][2] == 2
    batch = robsim.batch_estimate(trace).batch[0, 2]
    np.testing.assert_equal(result["batch_b1X"][2], batch)
    assert np.isnan(result["path_completed_step"]).any()  # None in the report
    assert result["pose_errors_x_rmse"][2] == robsim.pose_errors(trace).rmse[0]
    assert result["nees_mean"][2] == robsim.pose_consistency(trace).mean


def test_a_callback_with_a_memory_is_fresh_in_each_run_and_a_plain_function_is_used_as_it_is():
    vary = {"control": {"fresh": Faster, "plain": steady}}
    result = campaign(SCENARIO, vary=vary, metrics=[final], **{**OPTIONS, "runs": 2})
    assert result["final_x"][1] == by_hand(1, control=Faster()).pose_true[-1, 0]
    assert result["final_x"][3] == by_hand(1, control=steady).pose_true[-1, 0]


def test_folders_fill_a_slot_or_all(tmp_path):
    (tmp_path / "helper.py").write_text("left = 0.5\n")
    (tmp_path / "control.py").write_text(
        "import helper\nn = 0\n\n\ndef control(step):\n    global n\n    n += 1\n"
        "    import helper as again\n    return again.left, 0.01 * n\n"
    )
    (tmp_path / "measure.py").write_text("ENABLED = False\n\n\ndef measure(step): ...\n")
    for vary in ({"control": [tmp_path]}, {"folder": {"mine": str(tmp_path)}}):
        result = campaign(SCENARIO, vary=vary, metrics=[final], **OPTIONS)
        for run in (0, 5):
            seed = np.random.SeedSequence(5, spawn_key=(run,))
            scenario = SCENARIO.replace(seed=seed, control=None)
            sim = robsim.Simulation.from_folder(tmp_path, scenario=scenario)
            assert result["final_x"][run] == sim.run(20).pose_true[-1, 0]
    (tmp_path / "control.py").write_text("def control(step):\n    return 0, 0\n")
    assert result.trace(0, 5).pose_true[-1, 0] == result["final_x"][5]  # as they were then


def test_a_run_that_fails_is_a_row_with_the_error_and_its_line():
    result = campaign(SCENARIO, metrics=["tracking", failing_in_some], **OPTIONS)
    assert list(np.flatnonzero(result.failed)) == [3]
    error = "metric 'failing_in_some': ZeroDivisionError: it is one of these"
    assert result["error"][3] == error
    assert result["line"][3].startswith("campaign_code.py:")
    assert np.isnan(result["failing_in_some"][3])
    assert result["failing_in_some"][4] == 4
    alone = campaign(SCENARIO, metrics=["tracking"], **OPTIONS)  # nothing else is lost
    assert alone.metrics == result.metrics[:-1]
    for name in alone.metrics:
        np.testing.assert_array_equal(result[name], alone[name])
    for report in (result, result.summary()):
        text = " ".join(str(report).split())
        assert f"run 3 of the scenario: {error} (campaign_code.py:" in text
    assert result.summary().n[0, -1] == 5


def test_an_error_of_a_run_can_be_raised_as_it_is():
    with pytest.raises(ZeroDivisionError, match="it is one of these") as caught:
        campaign(SCENARIO, metrics=[failing_in_some], on_error="raise", **OPTIONS)
    notes = caught.value.__notes__
    assert notes[:2] == ["metric 'failing_in_some'", "in run 3 of the case the scenario"]


def test_a_callback_that_hangs_ends_by_the_time_limit():
    def hang(step):
        while True:
            pass

    result = campaign(
        SCENARIO,
        vary={"control": [hang]},
        metrics=[final],
        time_limit=0.05,
        **{**OPTIONS, "runs": 1},
    )
    assert result["error"][0].startswith("TimeoutError: the callback took longer")
    assert result["line"][0].startswith("test_campaign.py:")


def test_a_result_has_all_forms():
    result = campaign(SCENARIO, vary={"motor_delay": [0, 2]}, metrics=[final], **OPTIONS)
    frame = result.to_pandas()
    assert list(frame.columns) == list(result.columns)
    assert len(frame) == 12
    assert "<table" in result._repr_html_()
    assert result.to_dict()["failed"] == 0
    with pytest.raises(KeyError, match="finalx"):
        result["finalx"]
    with pytest.raises(ValueError, match="read-only"):
        result["final_x"][0] = 0
    summary = result.summary("motor_delay").to_pandas()
    assert summary.loc[("final_x", "0"), "mean"] == result["final_x"][:6].mean()
    assert result.summary(metrics="final_y").metrics == ("final_y",)
    with pytest.raises(ValueError, match="'final'"):
        result.summary(metrics=["final"])
    with pytest.raises(ValueError, match="'noise'"):
        result.summary("noise")


def test_cases_of_a_group_are_averaged_run_by_run():
    vary = {"control": {"fast": Faster, "plain": steady}, "motor_delay": [0, 2]}
    result = campaign(SCENARIO, vary=vary, metrics=[final], **OPTIONS)
    table = result["final_x"].reshape(2, 2, 6).mean(axis=1)
    summary = result.summary("control", metrics="final_x")
    assert summary.groups == ("fast", "plain")
    np.testing.assert_allclose(summary.mean[:, 0], table.mean(axis=1))
    np.testing.assert_allclose(summary.sd[1, 0], table[1].std(ddof=1))
    np.testing.assert_allclose(summary.difference[1, 0], (table[1] - table[0]).mean())


# The argument, and what the message must have.
REFUSED = [
    ({"metrics": []}, "metric"),
    ({"metrics": "trackng"}, "trackng"),
    ({"metrics": [lambda trace: 0]}, "metric"),
    ({"metrics": [final, final]}, "'final'"),
    ({"vary": {"nois": [1]}}, "nois"),
    ({"vary": {"motor_delay": []}}, "motor_delay"),
    ({"vary": {"motor_delay": [1, 1]}}, "label"),
    ({"vary": {"motor_delay": [-1]}}, "motor_delay"),
    ({"vary": {"control": {"a": Faster()}}}, "control"),
    ({"vary": {"control": {"a": lambda: 3}}}, "control"),
    ({"vary": {"control": ["nothing"]}}, "nothing"),
    ({"runs": 0}, "runs"),
    ({"executor": "thread"}, "executor"),
    ({"on_error": "ignore"}, "on_error"),
]


def test_wrong_arguments_are_refused_before_the_first_run():
    def metric(trace):
        raise AssertionError("a run was done")

    for wrong, message in REFUSED:
        given = {"metrics": {"mine": metric}, "on_error": "raise", **OPTIONS, **wrong}
        with pytest.raises((TypeError, ValueError, FileNotFoundError), match=message):
            campaign(SCENARIO, **given)


def test_every_metric_that_fails_is_named():
    def ending(trace):
        raise SystemExit(3)

    metrics = {"ending": ending, "final": final, "half": lambda trace: {"x": 1, "y": "text"}}
    metrics["motor"] = lambda trace: {"delay": 1}  # the column of an option
    metrics |= {"list": lambda trace: [1, 2], "numbered": lambda trace: {1: 2}}
    vary = {"motor_delay": [0]}
    result = campaign(SCENARIO, vary=vary, metrics=metrics, **{**OPTIONS, "runs": 1})
    assert result.metrics == ("final_x", "final_y")
    error = result["error"][0]
    assert error.startswith("metric 'ending': SystemExit: 3; metric 'half': TypeError")
    assert "duplicate column 'motor_delay'" in error
    assert "metric 'list'" in error
    assert "metric 'numbered'" in error
    assert result["line"][0].startswith("test_campaign.py:")


def test_the_progress_bar_counts_runs_and_those_that_failed(monkeypatch, tmp_path):
    class Bar:
        def __init__(self, **options):
            self.options, self.n, self.failed = options, options["initial"], 0
            bars.append(self)

        def update(self, n):
            self.n += n

        def set_postfix(self, failed, refresh):
            self.failed = failed

        def close(self):
            pass

    bars = []
    monkeypatch.setattr("robsim.campaigns.launch.progress_bar", Bar)
    for runs in (6, 11):
        options = {**OPTIONS, "runs": runs, "progress": True, "store": tmp_path / "store"}
        campaign(SCENARIO, metrics=[failing_in_some], **options)
    told = [(bar.options["initial"], bar.options["total"], bar.n, bar.failed) for bar in bars]
    assert told == [(0, 6, 6, 1), (6, 11, 11, 1)]
