"""What a worker says is checked: bytes of any kind end the run with slot and step, and no crash."""

import struct

import numpy as np
import pytest

from sizes import thorough
from worker_answers import (
    DONE,
    ERRORS,
    ESTIMATE,
    INPUT,
    MEASURED,
    MISSED,
    N_BLOBS,
    N_STATES,
    PARAMETERS,
    PARTS,
    STAGES,
    K,
    Refused,
    answer,
    good,
    run,
)

pytestmark = pytest.mark.sanitized


def test_an_answer_as_it_should_be_is_taken():
    trace = run(good)
    assert (trace.u == [0.5, 0]).all()
    assert (trace.pose_estimated == 0).all()


def bad(*parts, **said):
    return lambda message: answer(message, "u", "estimate", *parts, **said)


#: What cannot be an answer, by the slot that is told.
BAD = {
    "control": [
        bad(numbers=[(INPUT, np.nan)]),
        bad(numbers=[(INPUT + 8, np.inf)]),
        bad(numbers=[(INPUT, -12.1)]),
        lambda message: answer(message, "estimate"),
    ],
    "estimate_state": [
        bad(numbers=[(ESTIMATE + 16, np.nan)]),
        bad(numbers=[(ESTIMATE, 1e10)]),
        bad(numbers=[(ESTIMATE + 24, -1e-3)]),
        bad(numbers=[(ESTIMATE + 24, 1.0), (ESTIMATE + 32, 0.1)]),
        bad(numbers=[(ESTIMATE + 24, np.inf)]),
        bad(words=[(N_STATES, 1)], end=struct.pack("<d", np.nan)),
        bad(words=[(N_STATES, 1025)], end=bytes(8 * 1025)),
        lambda message: answer(message, "u"),
    ],
    "measure": [
        bad("measured", numbers=[(MEASURED, np.inf)]),
        bad("measured", "covariance", numbers=[(MEASURED + 24, -1.0)]),
        bad("measured", numbers=[(MEASURED + 96, np.inf)]),
        bad(words=[(N_BLOBS, 1)], end=struct.pack("<2d", np.inf, 0)),
        bad(words=[(N_BLOBS, 1)], end=struct.pack("<2d", 5.0, 5.0)),
    ],
    "estimate_parameters": [
        bad("parameters", numbers=[(PARAMETERS, np.nan)]),
        bad("errors", numbers=[(ERRORS, np.inf)]),
        bad(words=[(DONE, 14)]),
        bad(words=[(DONE, 16)]),
        bad(words=[(PARTS, 1024)]),
        bad(words=[(MISSED, 99)]),
        bad(words=[(N_BLOBS, 1 << 31)]),
        bad(words=[(N_STATES, 1)]),
        bad(words=[(K, 7)]),
        bad(end=b"x"),
        bad("frame"),
        lambda message: b"",
        lambda message: good(message)[:-1],
    ],
}


@pytest.mark.parametrize("slot", STAGES)
def test_an_answer_that_cannot_be_is_refused_with_slot_and_step(slot):
    for number, reply in enumerate(BAD[slot]):
        with pytest.raises(Refused) as refused:
            run(lambda m, reply=reply: reply(m) if struct.unpack_from("<q", m)[0] == 1 else good(m))
        assert refused.value.args[:2] == (slot, 1), number


@pytest.mark.long
@pytest.mark.parametrize("seed", range(thorough(9, 1)))
def test_random_answers_are_taken_or_refused(seed):
    """Each bit may be wrong; what gets through is finite."""
    rng = np.random.default_rng(seed)

    def spoiled(message):
        said = bytearray(good(message))
        for _ in range(rng.integers(4)):
            said[rng.integers(len(said))] ^= 1 << rng.integers(8)
        return bytes(said[: len(said) - (rng.random() < 0.05)])

    refusals = 0
    for _ in range(200):
        try:
            trace = run(spoiled, steps=1)
        except Refused:
            refusals += 1
            continue
        assert np.abs(trace.u).max() <= 12
        assert np.isfinite(trace.pose_estimated).all()
    assert 20 < refusals < 200


def test_a_state_of_another_size_is_refused_where_it_comes():
    def growing(message):
        (k,) = struct.unpack_from("<q", message)
        size = (0, 2, 0, 2, 3)[k]
        return answer(message, "u", "estimate", words=[(N_STATES, size)], end=bytes(8 * size))

    with pytest.raises(Refused) as refused:
        run(growing, steps=5)
    assert refused.value.args[:2] == ("estimate_state", 4)


class AnswerError(Exception):
    pass


def test_an_error_of_who_asks_comes_as_it_is():
    def failing(message):
        raise AnswerError(1)

    with pytest.raises(AnswerError):
        run(failing)
