"""Tasks as environments of gymnasium."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import robsim
import robsim.teach.gym
from robsim.teach.gym.environment import REWARDS

NAMES = ["Park", "Follow"]


def drive(env, policy, seed=1):
    """Run an episode; return the rewards and the last info."""
    observation, info = env.reset(seed=seed)
    rewards, is_over = [], False
    while not is_over:
        observation, reward, terminated, is_over, info = env.step(policy(observation))
        assert not terminated
        rewards.append(reward)
    return rewards, info


def still(observation):
    return np.zeros(2, np.float32)


@pytest.mark.parametrize("observation", ["pose", "frame"])
@pytest.mark.parametrize("name", NAMES)
def test_an_environment_passes_the_checker_of_gymnasium(name, observation):
    env = gymnasium.make(
        f"robsim/{name}-v0", observation=observation, render_mode="rgb_array", steps=20
    )
    check_env(env.unwrapped)
    env.close()


@pytest.mark.parametrize("name", NAMES)
def test_an_episode_is_a_run_of_the_task(name):
    env = gymnasium.make(f"robsim/{name}-v0", steps=30)
    rewards, info = drive(env, still)
    task = env.unwrapped.task
    assert len(rewards) == task.steps == 30
    assert info["scores"].keys() == {score.name for score in task.scores}


def test_the_same_actions_give_the_same_run_as_a_simulation():
    env = robsim.teach.gym.TaskEnv("park", steps=25)
    generator = np.random.default_rng(3)
    actions = generator.uniform(-1, 1, (25, 2)).astype(np.float32)
    remaining = iter(actions)
    drive(env, lambda observation: next(remaining))
    trace = env._simulation.trace
    again = robsim.teach.ParkTask(steps=25).simulation(
        seed=env_seed(seed=1), control=lambda step: tuple(map(float, actions[step.k]))
    )
    assert again.run(25) == trace[:25]


def env_seed(seed):
    return int(gymnasium.utils.seeding.np_random(seed)[0].integers(2**63))


def test_an_observation_is_what_was_measured_in_this_step():
    env = robsim.teach.gym.TaskEnv("park", noise=0, dropout=0, steps=10)
    observation, info = env.reset(seed=2)
    assert observation[3] == 1
    np.testing.assert_allclose(observation[:2], info["pose_true"][:2], atol=1)
    observation, _, _, _, info = env.step(np.ones(2, np.float32))
    np.testing.assert_allclose(observation[:2], info["pose_true"][:2], atol=1)


def test_a_robot_that_is_hidden_is_where_it_was_seen_last():
    env = robsim.teach.gym.TaskEnv("park", dropout=1, steps=10)
    observation, _ = env.reset(seed=1)
    width, height = env.task.scenario.area
    np.testing.assert_array_equal(observation, [width / 2, height / 2, 0, 0])


@pytest.mark.parametrize("name", ["park", "follow"])
def test_the_rewards_of_a_run_sum_to_what_was_done(name):
    idle = sum(drive(robsim.teach.gym.TaskEnv(name, steps=20), still)[0])
    assert idle == pytest.approx(0, abs=0.2)  # the motors are disturbed
    env = robsim.teach.gym.TaskEnv(name)
    with robsim.teach.solution_folder(env.task, env.task.solutions[0]).callbacks() as callbacks:

        def policy(observation):
            return np.array(callbacks["control"](env._simulation.last_step), np.float32)

        assert sum(drive(env, policy)[0]) > 1


def test_each_way_straight_to_the_parking_place_is_rewarded():
    task = robsim.teach.ParkTask()
    left = REWARDS[robsim.teach.ParkTask](task, np.zeros(3))
    x, y, heading = task.goal
    for error in np.linspace(-3.14, 3.14, 25):
        on_the_way = [left((x + d, y, heading + error)) for d in np.linspace(400, 0, 201)]
        assert (np.diff(on_the_way) < 0).all()
    turning = [left((x, y, heading + error)) for error in np.linspace(np.pi, 0, 50)]
    assert (np.diff(turning) < 0).all()
    assert turning[-1] == 0


def test_wrong_arguments():
    for name, value in (("task", "measure"), ("observation", "blobs"), ("render_mode", "human")):
        with pytest.raises(ValueError, match=name):
            robsim.teach.gym.TaskEnv(**{name: value})
    with pytest.raises(TypeError, match="noise"):
        robsim.teach.gym.TaskEnv(robsim.teach.ParkTask(), noise=3)


def test_there_is_no_step_before_the_first_reset():
    with pytest.raises(gymnasium.error.ResetNeeded):
        robsim.teach.gym.TaskEnv().step(np.zeros(2, np.float32))
