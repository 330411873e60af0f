import numpy as np
import pytest

import robsim


def driven(steps=800, **options):
    options = {"boundary": "unlimited", "seed": 4, "estimate_parameters": True, **options}
    return robsim.Simulation(control=robsim.DriveAround(), **options).run(steps)


def deviations(estimate, truth):
    """Relative error of a1, a2, b1, b2 and absolute error of d1."""
    relative = np.abs(estimate[:, :4] / truth[:, :4] - 1)
    return relative.max(), np.abs(estimate[:, 4] - truth[:, 4]).max()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_batch_and_online_on_true_data_of_a_drive(seed):
    trace = driven(seed=seed)
    assert np.abs(np.unwrap(trace.pose_true[:, 2])).max() > 2 * np.pi
    report = robsim.batch_estimate(trace)
    assert (report.start, report.stop) == (0, 800)
    relative, offset = deviations(report.batch, report.theta_true)
    assert relative < 1e-6
    assert offset < 1e-9
    relative, offset = deviations(report.online, report.theta_true)
    assert relative < 1e-4
    assert offset < 1e-6


def test_across_many_full_turns_of_the_heading():
    trace = robsim.Simulation(
        boundary="unlimited",
        estimate_parameters=True,
        control=lambda step: (0.9 + 0.3 * np.sin(step.k), 0.2 + 0.3 * np.sin(0.37 * step.k)),
    ).run(800)
    turns = np.unwrap(trace.pose_true[:, 2])[-1] / (2 * np.pi)
    assert turns > 10
    report = robsim.batch_estimate(trace)
    for estimate, limits in ((report.batch, (1e-6, 1e-9)), (report.online, (1e-4, 1e-6))):
        relative, offset = deviations(estimate, report.theta_true)
        assert relative < limits[0]
        assert offset < limits[1]


def test_a_bounce_ends_the_record_and_does_not_spoil_the_online_estimate():
    options = {"boundary": "bounce", "seed": 1, "estimate_parameters": True}
    control = robsim.DriveAround(low=0.5, high=1.5, hold=3)
    trace = robsim.Simulation(control=control, **options).run(2000)
    assert trace.bounced.sum() > 5
    report = robsim.batch_estimate(trace)
    record = slice(report.start, report.stop)
    assert not trace.bounced[record][1:].any()
    gaps = np.diff(np.concatenate(([0], np.flatnonzero(trace.bounced), [2000])))
    assert report.stop - report.start == gaps.max()
    for estimate, limit in ((report.batch, 1e-6), (report.online, 1e-4)):
        assert deviations(estimate, report.theta_true)[0] < limit


def test_from_measurements_the_record_has_no_gap():
    def measure(step):
        return None if step.k in (100, 400) else robsim.Measurement((step.k, 0.0, 0.0))

    trace = driven(500, measure=measure, camera=(240, 240))
    report = robsim.batch_estimate(trace, identify_from="measurement")
    assert (report.start, report.stop) == (101, 400)
    assert "from measurement, steps 101..399" in report.title


def test_a_part_of_a_trace_keeps_its_step_numbers():
    report = robsim.batch_estimate(driven()[200:500])
    assert (report.start, report.stop) == (200, 500)


def test_what_a_record_without_motion_does_not_determine_is_said():
    trace = robsim.Simulation(
        control=lambda step: (0.0, 0.0),
        define_model=lambda: robsim.RobotModel(robsim.RobotParameters(motor_offset=(0.0, 0.0))),
    ).run(50)
    report = robsim.batch_estimate(trace)
    assert (report.rank < 5).all()
    assert np.isnan(report.batch).any()
    assert "determines" in str(report)
    assert "no online estimate" in str(report)
    assert report.to_dict()["b1X"]["batch"] is None


@pytest.mark.parametrize(
    ("steps", "source", "message"),
    [(5, "truth", "at least 5 samples"), (50, "measurement", "got 0"), (0, "truth", "of 0 steps")],
)
def test_a_record_that_is_too_short_is_refused(steps, source, message):
    with pytest.raises(ValueError, match=message):
        robsim.batch_estimate(robsim.Simulation().run(steps), identify_from=source)


def test_the_source_must_be_known():
    with pytest.raises(ValueError, match="'truth', 'measurement', 'estimate', got 'magic'"):
        robsim.batch_estimate(driven(20), identify_from="magic")


def test_the_report_reads_like_the_manuals():
    report = robsim.batch_estimate(driven())
    lines = str(report).splitlines()
    assert lines[0] == "Batch estimate from truth, steps 0..799 (798 samples)"
    assert lines[2].split() == ["True", "value", "Batch", "estimate", "Online", "estimate"]
    row = next(line for line in lines if line.startswith("b1P")).split()
    assert row == ["b1P", "0.030556", "0.030556", "0.030556"]
    assert sum(set(line) == {"-"} for line in lines) == 5
    assert report._repr_html_().count("<tr>") == 16
