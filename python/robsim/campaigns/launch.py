"""`campaign`: many runs over seeds and options, in one call."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing
from operator import itemgetter
from os import PathLike
from typing import Any, NoReturn

from robsim.base.checks import check_bool, check_choice
from robsim.base.files import as_path
from robsim.base.seeds import Seed
from robsim.base.text import one_line
from robsim.campaigns._store import Store
from robsim.campaigns.engines.campaign_work import DIED, CampaignWork, Chunks, check_can_be_sent
from robsim.campaigns.engines.engine import Engine, engine_value, rows_by
from robsim.campaigns.engines.executors import DaskClient
from robsim.campaigns.engines.processes import end_copy
from robsim.campaigns.result import CampaignResult, result_of
from robsim.campaigns.runs import CaseRuns, Row
from robsim.campaigns.spec import CampaignSpec
from robsim.simulation import Scenario
from robsim.simulation.runner import progress_bar


def campaign(
    scenario: Scenario | None = None,
    *,
    vary: Mapping[str, Iterable[Any] | Mapping[str, Any]] | None = None,
    metrics: Iterable[str | Callable[..., Any]] | Mapping[str, Any] | str | Callable[..., Any],
    runs: int,
    steps: int,
    seed: Seed = None,
    executor: int | str | Executor | DaskClient | None = None,
    store: str | PathLike[str] | None = None,
    time_limit: float | None = None,
    keep: str = "numbers",
    progress: bool = True,
    on_error: str = "record",
) -> CampaignResult:
    """Run a simulation many times with different seeds and options, and compare the results.

    Parameters
    ----------
    scenario : Scenario, optional
        The common options of the runs. Default: ``Scenario()``.
    vary : mapping of str to values, optional
        Options of `Simulation`, and their values: a list, or a mapping of label to value. The cases
        are all combinations of these values; see Notes for slots. Default: one case.
    metrics : names or functions of the trace
        Numbers to compute from each run, one or several: names, functions, or a mapping of name to
        either. A function returns a number, a dict of numbers, or a `Report`, which gives its
        numbers. The names are ``"tracking"``, ``"measurement_errors"``, ``"pose_errors"``,
        ``"nees"``, ``"parameters"`` and ``"batch"``. Here ``"pose_errors"`` and ``"nees"`` refer to
        the estimated pose (angles in rad), and ``"parameters"`` refers to the last online estimate.
        A score function requires further arguments:
        ``functools.partial(robsim.score_path, waypoints=square)``, for example.
    runs : int
        Number of runs of each case.
    steps : int
        Number of steps of each run.
    seed : int, SeedSequence or Generator, optional
        Source of the runs' seeds. Run i has the same seed in every case, for any number of runs:
        ``SeedSequence(seed, spawn_key=(i,))``. Default: the scenario's seed, else the store's seed,
        else an unpredictable seed.
    executor : int, "threads", concurrent.futures.Executor or Dask Client, optional
        The engine: a number of processes, as many threads as processors, an executor, or a Dask
        ``Client``. An executor, such as loky's or mpi4py's, is used unchanged. A client may use any
        cluster on which robsim and the modules of your code are installed. Default: this thread.
        The numbers are the same.
    store : path, optional
        SQLite file that keeps the rows. Existing rows are not run again: the same call continues an
        interrupted campaign, and a call with more `runs` adds rows. Default: in memory.
    time_limit : float, optional
        Maximum duration of a call of a callback (s); a run that exceeds it fails. Wall-clock time
        counts: on a busy machine a tight limit makes runs fail by chance.
    keep : str
        Content of the store for each run: ``"numbers"``, or its trace, too: ``"traces"``, for
        `trace` of the result. A trace of 100 steps with measurements needs about 35 kB. Existing
        rows stay unchanged.
    progress : bool
        Show a progress bar in a terminal or a notebook: rate, failed runs, time left.
    on_error : str
        ``"record"``: an exception in a run, or in a metric, gives a row with the error and its
        line; the numbers of the other metrics are kept.
        ``"raise"``: the exception is raised.

    Returns
    -------
    CampaignResult
        A row for each run in the order cases x runs, with the methods `summary`, `trace` and
        `to_pandas`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range, or if code cannot be sent to other
        processes. If the store belongs to another campaign, or is damaged.
    OSError
        If the store cannot be read or written; previously committed rows are intact.

    Notes
    -----
    A value of a slot (``estimate_state``, ``control`` and so on) is a native component, True or
    None, as for `Simulation`, or code:

    - a class, or a function without arguments, that makes the callback of a run: for callbacks with
      memory, such as a filter; ``functools.partial(MyFilter, q=2)`` adds arguments;
    - a plain function that is the callback, such as ``control(step)``, without memory;
    - the path of a folder whose file for the slot is used, loaded again for each run. The values of
      the option ``"folder"`` are callback folders: each file fills its slot.

    In other processes, each function must be defined at the top level of a module; a lambda or a
    nested function cannot run there. A script must call `campaign` below
    ``if __name__ == "__main__":``. With threads, runs without Python callbacks run in parallel, and
    other runs take turns.

    A dead process is replaced, and its runs are repeated; a run that ends its process at each
    attempt is recorded as failed. The same holds for a Dask client, whose nannies restart the
    workers. Any other executor stays broken after a dead process; the same call with a new executor
    continues the campaign. In this thread and in separate processes, `time_limit` ends a sleeping
    callback, but not a callback stuck in compiled code.

    A store belongs to a single campaign: a campaign with other steps, seeds, options, metrics or
    code is refused. Code is identified by its own text, not by the code it calls. Its view
    ``results`` has a row for each run.

    Examples
    --------
    >>> scenario = robsim.Scenario(area=(300, 300), start="random", measure=True)
    >>> result = robsim.campaign(
    ...     scenario,
    ...     vary={"noise": {0: None, 10: robsim.GaussianNoise(10)}},
    ...     metrics="tracking",
    ...     runs=20,
    ...     steps=20,
    ...     seed=1,
    ... )
    >>> result["tracking_rmse_xy"].shape
    (40,)
    >>> print(result.summary("noise"))  # doctest: +SKIP
    """
    spec = CampaignSpec(
        scenario=scenario,
        vary=vary,
        metrics=metrics,
        runs=runs,
        steps=steps,
        seed=seed,
        time_limit=time_limit,
        keep=keep,
    )
    return run_spec(spec, executor=executor, store=store, progress=progress, on_error=on_error)


def run_spec(
    spec: CampaignSpec,
    *,
    executor: Engine,
    store: str | PathLike[str] | None,
    progress: bool,
    on_error: str = "record",
    known: Sequence[Row] = (),
) -> CampaignResult:
    """Do the runs of a specification, except `known` rows; other arguments: see `campaign`."""
    engine = engine_value(executor)
    end_copy()
    check_bool("progress", progress)
    check_choice("on_error", on_error, ("record", "raise"))
    file = None if store is None else as_path(store, "store")
    if file is None and spec.keep == "traces":
        raise ValueError("keep='traces' needs a file for the traces: also give store")
    with closing(Store(file, spec)) as rows:
        rows.add(known)
        _run(rows.spec, engine, rows, shows=progress, stops=on_error == "raise")
        return result_of(rows.spec, rows.read(), file)


def _run(spec: CampaignSpec, engine: Engine, store: Store, *, shows: bool, stops: bool) -> None:
    """Do the runs missing in the store."""
    total, done = len(spec.cases) * spec.runs, store.count()
    bar = progress_bar(total=total, initial=done, unit="run") if shows else None
    failed = 0
    try:
        if isinstance(engine, int):
            check_can_be_sent(spec)
        jobs = Chunks(store.missing())
        if spec._shares_frames:  # run by run, then, and not case by case
            jobs = Chunks(sorted(store.missing(), key=itemgetter(1)), together=len(spec.cases))
        with closing(rows_by(engine, CampaignWork(spec), jobs)) as chunks:
            for rows in chunks:
                wrong = [row for row in rows if row.error is not None]
                if wrong and stops:
                    store.add([row for row in rows if row.error is None])
                    _raise(spec, wrong[0])
                store.add(rows)
                failed += len(wrong)
                if bar is not None:
                    bar.set_postfix(failed=failed, refresh=False)
                    bar.update(len(rows))
    except BaseException as error:
        error.add_note(_how_to_go_on(store, total))
        raise
    finally:
        if bar is not None:
            bar.close()


def _raise(spec: CampaignSpec, row: Row) -> NoReturn:
    """Raise the error of a run by repeating it here."""
    case = spec.cases[row.case]
    where = f"in run {row.run} of the case {case}"
    if row.error == DIED:  # as this one would
        raise RuntimeError(f"{where}: {row.error}")
    try:
        CaseRuns(spec, case).numbers(row.run)
    except Exception as error:
        error.add_note(where)
        raise
    raise RuntimeError(f"{where}: {row.error}; a repeat of the run did not fail")


def _how_to_go_on(store: Store, total: int) -> str:
    if store.path is None:
        return "the finished runs are lost: with store=FILE the same call continues"
    return (
        f"{one_line(store.path)} has {store.count()} of {total} runs: the same call continues "
        "with the others"
    )
