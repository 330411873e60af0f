"""Honest submissions by the slots that they fill, and runs of them with and without a worker."""

import os
import sys
import textwrap

import numpy as np

import robsim
from robsim.teach import WorkerLimits
from robsim.teach.grading.graded_run import all_here, graded_run
from robsim.teach.grading.keys import RunSeeds
from robsim.teach.grading.task import Task
from robsim.teach.isolation._layers import layer as layer
from robsim.teach.submissions import Rules, read_submission

zygotes = None
if sys.platform != "win32":
    from robsim.teach.isolation._processes import zygotes
if sys.platform == "linux":
    from robsim.teach.isolation._layers import landlock as landlock
    from robsim.teach.isolation._layers import users as users

#: Minutes: honest code never comes to them, on a busy machine neither.
PATIENT = WorkerLimits(call=300.0, first_call=300.0, run=600.0, cpu=300.0)

HONEST = {
    "define_model": """
        import robsim
        def define_model():
            return robsim.RobotModel(robsim.RobotParameters(mass=0.36))
        """,
    "init_parameter_estimator": """
        import robsim
        def init_parameter_estimator(model):
            return robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.99)
        """,
    "estimate_parameters": """
        def estimate_parameters(step):
            if step.sample is None:
                return None
            return 0.9 * step.estimator.update(step.sample.phi, step.sample.y)
        """,
    "measure": """
        import numpy as np, robsim
        last = []
        def measure(step):
            last.append(step.frame)
            if len(last) > 3 and not np.array_equal(last[-3].image, last[-3].image.copy()):
                raise ValueError("a frame that was kept has changed")
            found = robsim.locate(step.blobs, step.markers, plane_map=step.frame.plane_map)
            if found is None:
                return None
            return np.add(found.pose, last[0].image[:9, :9].mean() / 100)
        """,
    "estimate_state": """
        import numpy as np, robsim
        inner = robsim.estimation.reference.ExtendedKalmanFilter()
        def estimate_state(step):
            estimate = inner(step)
            return robsim.Estimate(estimate.pose, 2 * estimate.covariance, state=[step.k, step.u0])
        """.replace("step.u0", "step.last_u[0]"),
    "control": """
        import robsim
        around = robsim.DriveAround()
        def control(step):
            u = around(step)
            if step.measurement is not None:
                u = u + 1e-4 * step.measurement.pose[:2]
            if step.estimate is not None:
                u = u - 1e-4 * step.estimate.pose[:2]
            if step.parameters is not None:
                u = u + 1e-3 * step.parameters[0, 0]
            return u + 0.1 * step.last_u
        """,
}


def folder_of(folder, **files):
    """Write a submission: a file for each of its slots, and others."""
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.py").write_text(textwrap.dedent(text))
    return folder


def honest(folder, slots):
    """Write one that fills these slots well."""
    return folder_of(folder, **{slot: HONEST[slot] for slot in slots})


def task_of(folder, slots, **options):
    """What is to be run of a submission; `options`: of a `Task`, or callbacks of the teacher's."""
    rules = Rules(slots=tuple(slots))
    frames = options.pop("frames", None)
    return Task(
        submission=read_submission(folder, rules),
        rules=rules,
        callbacks=options,
        frames=frames,
        limits=PATIENT,
    )


def ran(folder, slots, scenario, *, steps=20, seed=1, **options):
    """Run a submission in a worker; return its trace."""
    return graded_run(task_of(folder, slots, **options), scenario, steps, RunSeeds.of(seed)).result


def ran_here(folder, slots, scenario, *, steps=20, seed=1, **options):
    """Run it in this process."""
    with all_here(task_of(folder, slots, **options), scenario, RunSeeds.of(seed)) as simulation:
        return simulation.run(steps)


def assert_same_trace(one, other):
    assert one.info == other.info
    columns, others = one._groups, other._groups
    assert list(columns) == list(others)
    for name, column in columns.items():
        assert column.tobytes() == others[name].tobytes(), name


def random_scenario(rng):
    """A scenario with any of what may happen in a world."""
    size = [(300, 300), (400, 300), (240, 240)][rng.integers(3)]
    return robsim.Scenario(
        resolution=size,
        boundary=["bounce", "unlimited"][rng.integers(2)],
        headings=[36, None][rng.integers(2)],
        noise=[None, robsim.GaussianNoise(8), robsim.UniformNoise(10)][rng.integers(3)],
        dropout=[None, robsim.Dropout(0.2, 3)][rng.integers(2)],
        process_noise=[None, robsim.WheelNoise((0.02, 0.02))][rng.integers(2)],
        mismatch=[None, robsim.ParameterMismatch(0.05)][rng.integers(2)],
        camera_delay=int(rng.integers(3)),
        motor_delay=float(rng.integers(5)) / 2,
        start=[None, "random"][rng.integers(2)],
        identify_from=["truth", "measurement"][rng.integers(2)],
        measure=True,
        estimate_parameters=bool(rng.integers(2)),
        control=[robsim.Spin(), robsim.DriveAround(), robsim.Replay(np.full((99, 2), 0.4))][
            rng.integers(3)
        ],
    )


def where(trace):
    """A metric: the process that grades a run, and the one that starts its workers."""
    (process,) = [zygote.process for zygote in zygotes._zygotes.values()]
    return {"grader": os.getpid(), "zygote": process}
