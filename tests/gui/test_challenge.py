"""A task as a challenge: score, stars, the best score."""

import json

import pytest

import robsim
from browsers import FakeBrowser
from robsim.gui.panels.run.challenge import _MOST_KEPT, _best
from robsim.teach.tasks.trial import reference_run, stars_of, trial_of
from robsim.vision.robots.lookup import data_folder

pytestmark = pytest.mark.usefixtures("user_folder")
TASK = robsim.teach.ParkTask(steps=60)


def score_of(panel, **wanted):
    """Wait for a score with these fields."""
    browser = FakeBrowser(panel._view)
    while True:
        head, _ = browser.take("score")
        if wanted.items() <= head.items():
            return head


def own_control(step):
    return 0.3, 0.2


@pytest.mark.slow
def test_the_score_is_that_of_a_trial_and_the_best_is_kept():
    simulation = TASK.simulation(seed=3, control=own_control)
    with robsim.panel(simulation, task=TASK) as panel:
        assert panel.message("hello", width=1)[0]["challenge"]["steps"] == 60
        for _ in range(TASK.steps):
            panel.step()
        trial = trial_of(TASK, panel.trace, reference_run(TASK, simulation._seed))
        told = score_of(panel, points=trial.points)
        assert told["best"] == trial.points
        assert told["stars"] == stars_of(trial)
        assert [row[0] for row in told["rows"]] == [score.title for score in TASK.scores]
        assert (told["by_hand"], told["changed"]) == ([], [])
    reference = reference_run(TASK, simulation._seed)
    assert stars_of(trial_of(TASK, reference, reference)) == 3


@pytest.mark.slow
def test_another_world_keeps_no_score_and_hands_have_their_own():
    simulation = TASK.simulation(seed=3)
    with robsim.panel(simulation, task=TASK) as panel:
        panel.message("go_to", x=300, y=300)
        for _ in range(TASK.steps):
            panel.step()
        by_hand = score_of(panel, by_hand=["control"])["best"]
        assert by_hand is not None
        panel.message("set", name="noise", value="none")
        panel.step()
        assert score_of(panel, changed=["noise"])["best"] == by_hand
    with robsim.panel(TASK.simulation(seed=3, control=own_control), task=TASK) as panel:
        panel.step()
        assert score_of(panel)["best"] is None


def test_the_kept_scores_are_few_and_survive_a_damaged_file():
    file = data_folder() / "challenges.json"
    for text in ("", "[]", "{", '{"a": "x", "b": 3, "c": NaN}', "\0"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        assert _best("a", None) is None
    for k in range(_MOST_KEPT + 5):
        assert _best(f"challenge {k}", 0.5) == 0.5
    assert _best("challenge 204", 0.25) == 0.5
    kept = json.loads(file.read_text())
    assert len(kept) == _MOST_KEPT
    assert _best("challenge 0", None) is None


def test_a_task_is_for_a_simulation():
    with pytest.raises(TypeError, match="task"):
        robsim.panel(robsim.Simulation().run(2), task=TASK)
    with pytest.raises(TypeError, match="task"):
        robsim.panel(robsim.Simulation(), task="park")
