import numpy as np
import pytest

from robsim import DriveAround, Replay, Simulation

NAN, INF = np.nan, np.inf
U = np.arange(6.0).reshape(3, 2) / 10


def test_a_run_is_driven_once_more():
    first = Simulation(control=DriveAround(), seed=1).run(40)
    again = Simulation(control=Replay(first.u)).run(40)
    assert np.array_equal(again.u, first.u)
    assert np.array_equal(again.pose_true, first.pose_true)


def test_beyond_the_end_there_is_no_input():
    sim = Simulation(control=Replay(U))
    with pytest.raises(IndexError, match=r"3 rows.*step 3"):
        sim.run(5)
    assert np.array_equal(sim.trace.u, U)
    assert len(Simulation(control=Replay(U)).run(3)) == 3


def test_no_inputs_at_all():
    assert Replay(np.empty((0, 2))).u.shape == (0, 2)
    with pytest.raises(IndexError, match="0 rows"):
        Simulation(control=Replay(np.empty((0, 2)))).run(1)


def test_the_inputs_are_its_own_and_read_only():
    given = U.copy()
    replay = Replay(given)
    given[:] = 9
    u = replay.u
    del replay
    assert np.array_equal(u, U)
    with pytest.raises(ValueError, match="read-only"):
        u[0] = 1


def test_what_is_no_record_of_inputs():
    for wrong in ([], U.T, U[0], U[None], [(1, NAN)], [(INF, 1)]):
        with pytest.raises(ValueError, match=r"^u\b"):
            Replay(wrong)
