"""The solutions that ship are as good, and as bad, as they always were."""

import json
from pathlib import Path

import numpy as np
import pytest

from kept_scores import scores_of

pytestmark = pytest.mark.long

KEPT = json.loads((Path(__file__).parents[1] / "data" / "solutions.json").read_text())


def numbers_of(solution):
    return {key: [float.fromhex(one) for one in row] for key, row in solution["scores"].items()}


@pytest.mark.kernels
@pytest.mark.filterwarnings("ignore:.*looks like degrees")
@pytest.mark.parametrize("name", KEPT)
def test_no_solution_got_better_or_worse(name):
    found = scores_of(name)
    assert found.keys() == KEPT[name].keys()
    for solution, kept in KEPT[name].items():
        own = found[solution]
        assert own["is_right"] == kept["is_right"], solution
        # Not bit by bit, as `python -m kept_scores` compares: the last digits of linear algebra
        # depend on the processor, and an estimator that diverges makes them larger.
        points = float.fromhex(kept["points"])
        assert float.fromhex(own["points"]) == pytest.approx(points, abs=1e-5), solution
        for score, values in numbers_of(kept).items():
            np.testing.assert_allclose(numbers_of(own)[score], values, rtol=1e-3, err_msg=solution)


def test_all_right_and_wrong_solutions_are_there():
    right = [one["is_right"] for task in KEPT.values() for one in task.values()]
    assert (sum(right), len(right) - sum(right)) == (16, 41)
