"""The red team: no attack gets a point that it did not earn, and nothing of it is left."""

import sys

import numpy as np
import pytest

from graded import zygotes
from red_team import ATTACKS, HONEST, LAYERS
from red_team.ground import SCENARIO, STEPS_AFTER, check_after, check_outcome, ground
from robsim.teach import check_isolation
from sizes import thorough

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="looks at what is left by /proc"),
    pytest.mark.long,
]

#: Tried each time: one of each kind.
SAMPLE = (
    *("garbage collector", "write to the ring", "samples of the truth", "dead reckoning"),
    *("the teacher's files", "results of its own", "os._exit(0)", "a daemon", "sockets"),
    *("an answer to another step", "NaN on the wire", "READY with another model"),
    *("a masked module by its source", "__str__ that exits", "somebody else's fault"),
    *("objects for numbers", "a huge result", "NaN behind its back", "a pickle for a result"),
    *("a late result", "a result by a thread"),
)

#: What may come to something else where the process alone holds it.
BARE = [name for name, attack in ATTACKS.items() if attack.runs_bare and attack.held_by == LAYERS]
BARE += ["memory by process_vm_readv", "trace", "write to the ring", "threads that spin"]
BARE_SAMPLE = [
    *("the teacher's files", "files outside its folder", "a daemon", "a fork that answers, too"),
    *("threads that spin", "trace"),
]


@pytest.fixture(scope="module")
def shut_in():
    """Whether all layers hold on this machine."""
    return bool(check_isolation())


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    with ground(tmp_path_factory.mktemp("class")) as made:
        yield made
    zygotes.close_zygotes()


@pytest.fixture(scope="module")
def first(place):
    """The first traces of an honest submission, before all attacks; it has its point."""
    levels = ("auto", "process")
    for level in levels:
        assert place.outcome(HONEST, isolation=level).points == 1
    return {n: place.outcome(HONEST, isolation=n, steps=STEPS_AFTER).trace for n in levels}


def attacked(place, first, name, isolation, shut_in):
    """Run an attack, twice if it may leave something for itself, and look at all that follows."""
    attack, before = ATTACKS[name], place.left()
    for _ in range(2 if name == "a second run" else 1):
        outcome = place.outcome(attack, isolation=isolation)
        check_outcome(attack, outcome, shut_in=shut_in)
    if not shut_in:
        place.clear()
    check_after(place, before, first[isolation], isolation=isolation)
    return outcome


@pytest.mark.parametrize("name", SAMPLE)
def test_a_sample_gets_nowhere(place, first, shut_in, name):
    attacked(place, first, name, "auto", shut_in)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in ATTACKS if name not in SAMPLE])
def test_the_others_get_nowhere(place, first, shut_in, name):
    attacked(place, first, name, "auto", shut_in)


@pytest.mark.slow
@pytest.mark.parametrize("name", thorough(BARE, BARE_SAMPLE))
def test_with_the_process_alone_none_has_points_and_nothing_runs_on(place, first, name):
    attacked(place, first, name, "process", False)


NO_BLANKS = {
    "guess the seed of a frame": ({}, {"key": None, "seed": 7}),
    "clean frames in the ring": ({"noise": None}, {}),
    "samples of the truth": ({"estimate_parameters": True, "identify_from": "measurement"}, {}),
}


@pytest.mark.parametrize("name", NO_BLANKS)
def test_it_gets_there_where_its_assignment_lets_it(place, name):
    world, options = NO_BLANKS[name]
    assert place.outcome(ATTACKS[name], SCENARIO.replace(**world), **options).reached


def test_dead_reckoning_is_enough_where_the_world_is_its_model(place):
    same = SCENARIO.replace(process_noise=None, mismatch=None, noise=None)
    assert place.outcome(ATTACKS["dead reckoning"], same).points == 1


def test_samples_of_the_truth_are_not_there_where_parameters_are_identified_from_it(place):
    truth = SCENARIO.replace(estimate_parameters=True)
    outcome = place.outcome(ATTACKS["samples of the truth"], truth)
    check_outcome(ATTACKS["samples of the truth"], outcome, shut_in=True)
    assert np.isfinite(outcome.trace.parameters[-1]).all()
