"""`flotilla.environments`: by the checkers of Gymnasium and PettingZoo, against numpy, against each other, and what baselines are worth."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from pettingzoo.test import parallel_api_test, parallel_seed_test

from environment_reference import Reference
from flotilla.environments import FlotillaEnv, FlotillaParallelEnv, FlotillaVectorEnv

SEED = 20


def episode(env: Any, act: Any, seed: int) -> tuple[float, float]:
    """Sum of rewards, and contacts, of one episode."""
    env.reset(seed=seed)
    rewards, contacts, over = 0.0, 0.0, False
    while not over:
        _, reward, terminated, truncated, info = env.step(act(env))
        rewards, contacts = rewards + reward, contacts + info["contacts"]
        over = terminated or truncated
    return rewards, contacts


@pytest.mark.filterwarnings("ignore:.*(infinity|inf).*")
@pytest.mark.parametrize("task", ["velocity", "station"])
@pytest.mark.parametrize("fidelity", ["cycle", "module"])
@pytest.mark.parametrize("action", ["swing", "wrench"])
def test_gymnasium_finds_nothing_wrong(task: str, fidelity: str, action: str) -> None:
    name = f"Flotilla/{task.capitalize()}-v0"
    env = gymnasium.make(name, fidelity=fidelity, action=action, duration_s=6.0)
    check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize("fidelity", ["cycle", "module"])
def test_pettingzoo_finds_nothing_wrong(fidelity: str) -> None:
    def make() -> FlotillaParallelEnv:
        return FlotillaParallelEnv(fidelity=fidelity, duration_s=9.0)

    parallel_api_test(make(), num_cycles=20)
    parallel_seed_test(make)


def test_the_cycle_fidelity_is_that_of_numpy() -> None:
    worst, touched, steps, same = 0.0, 0, 0, 0
    for task in ("velocity", "station"):
        for seed in range(SEED, SEED + 2):
            env = FlotillaEnv(task=task, fidelity="cycle", scenario="nine")
            env.action_space.seed(seed)
            seen, info = env.reset(seed=seed)
            heading_rad = info["heading_rad"]
            to_world = np.array([
                [np.sin(heading_rad), np.cos(heading_rad)], [-np.cos(heading_rad), np.sin(heading_rad)],
            ])
            positions_m = np.array([[x, y] for y in (-0.15, 0.0, 0.15) for x in (-0.15, 0.0, 0.15)])
            reference = Reference(
                positions_m=positions_m,
                position_m=np.array([info["x_m"], info["y_m"]]),
                heading_rad=heading_rad,
                velocity_m_s=to_world @ seen[2:4] if task == "velocity" else None,
                station_m=to_world @ seen[0:2] if task == "station" else None,
                heading_asked_rad=heading_rad + np.arctan2(seen[6], seen[7]),
            )
            over = False
            while not over:
                action = env.action_space.sample()
                seen, reward, _, over, info = env.step(action)
                expected, rewarded, clearance_m = reference.step(action)
                contacts = info["contacts"]
                # What comes this near to a touch may be either between two samples.
                sure, possible = np.sum(clearance_m < -2e-3), np.sum(clearance_m < 2e-3)
                assert sure <= contacts <= possible, f"seed {seed}, {task}: {np.sort(clearance_m)[:5]}"
                without = reward + contacts, rewarded + np.sum(clearance_m < 0)
                place = np.array([info["x_m"], info["y_m"], info["heading_rad"]])
                off = max(
                    np.max(np.abs(seen - expected)),
                    np.max(np.abs(reference.state[:3] - place)),
                    abs(without[0] - without[1]),
                )
                worst, touched = max(worst, float(off)), touched + int(contacts)
                steps, same = steps + 1, same + int(reward == pytest.approx(rewarded, abs=1e-9))
                assert off < 1e-9, f"seed {seed}, {task}: {off}"
    print(f"worst difference {worst:.1e}, {touched} contacts in {steps} steps, {same} with the same reward")
    assert touched > 100
    assert same > 0.9 * steps


@pytest.mark.parametrize("fidelity", ["cycle", "module"])
def test_an_environment_of_a_batch_is_one_alone(fidelity: str) -> None:
    count = 4
    vector = FlotillaVectorEnv(count, fidelity=fidelity, duration_s=6.0)
    vector.action_space.seed(SEED)
    seen, _ = vector.reset(seed=SEED)
    alone = [FlotillaEnv(fidelity=fidelity, duration_s=6.0) for _ in range(count)]
    first = [env.reset(seed=SEED + index)[0] for index, env in enumerate(alone)]
    assert np.array_equal(seen, first)
    over = np.zeros(count, dtype=np.bool_)
    for _ in range(8):
        actions = vector.action_space.sample()
        seen, rewards, terminated, truncated, info = vector.step(actions)
        for index, env in enumerate(alone):
            if over[index]:
                expected, reward, ends = env.reset()[0], 0.0, (False, False)
            else:
                expected, reward, *ends, told = env.step(actions[index])
                assert told["contacts"] == info["contacts"][index]
            assert np.array_equal(seen[index], expected), f"environment {index}, seed {SEED}"
            assert rewards[index] == reward
            assert tuple(ends) == (terminated[index], truncated[index])
        over = terminated | truncated
    assert info["_contacts"].all()


def test_gymnasium_makes_batches_by_name_and_wraps_them() -> None:
    envs = gymnasium.make_vec("Flotilla/Station-v0", num_envs=4, fidelity="cycle", duration_s=12.0)
    assert isinstance(envs.unwrapped, FlotillaVectorEnv)
    counted = RecordEpisodeStatistics(envs)
    seen, _ = counted.reset(seed=SEED)
    assert np.all(np.hypot(seen[:, 0], seen[:, 1]) > 0.0), "a station is asked for"
    rewards, episodes = np.zeros(4), 0
    for _ in range(30):
        _, reward, terminated, truncated, info = counted.step(envs.unwrapped.baseline())
        rewards = rewards + reward
        over = terminated | truncated
        if over.any():
            assert np.allclose(info["episode"]["r"][over], rewards[over])
            rewards, episodes = np.where(over, 0.0, rewards), episodes + int(over.sum())
    assert episodes >= 12


def test_chosen_environments_are_reset() -> None:
    vector = FlotillaVectorEnv(3, fidelity="cycle")
    first, _ = vector.reset(seed=SEED)
    vector.step(vector.action_space.sample())
    mask = np.array([False, True, False])
    seen, info = vector.reset(seed=[None, SEED + 1, None], options={"reset_mask": mask})
    assert np.array_equal(seen[1], first[1])
    assert not seen[0].any()
    assert np.array_equal(info["_time_s"], mask)


def test_agents_are_the_structure() -> None:
    whole = FlotillaEnv(fidelity="cycle", scenario="nine")
    agents = FlotillaParallelEnv(fidelity="cycle", scenario="nine")
    seen, _ = whole.reset(seed=SEED)
    each, _ = agents.reset(seed=SEED)
    whole.action_space.seed(SEED)
    for _ in range(5):
        action = whole.action_space.sample()
        seen, reward, *_ = whole.step(action)
        parts = dict(zip(agents.possible_agents, action.reshape(-1, 3), strict=True))
        each, rewards, *_ = agents.step(parts)
        assert set(rewards.values()) == {reward}
        assert np.array_equal(agents.state(), seen)
        tails = seen[12:].reshape(-1, 2)
        # The middle module has a neighbour on each side; the first one on its right and ahead.
        middle, corner = each["module_5"], each["module_1"]
        assert np.array_equal(middle[:12], seen[:12])
        assert np.allclose(middle[12:14], 0.0)
        assert np.allclose(corner[12:14], -0.15)
        assert np.array_equal(middle[14:16], tails[4])
        for place, module in enumerate([5, 3, 7, 1]):
            assert np.array_equal(middle[16 + 3 * place : 19 + 3 * place], [1.0, *tails[module]])
        assert np.array_equal(corner[16:28], [1, *tails[1], 0, 0, 0, 1, *tails[3], 0, 0, 0])


@pytest.mark.parametrize("task", ["velocity", "station"])
@pytest.mark.parametrize("fidelity", ["cycle", "module"])
def test_baselines_do_far_better_than_chance(task: str, fidelity: str) -> None:
    env = FlotillaEnv(task=task, fidelity=fidelity, duration_s=45.0)
    env.action_space.seed(SEED)
    seeds = range(SEED, SEED + 3)

    def total(act: Any) -> tuple[float, float]:
        each = [episode(env, act, seed) for seed in seeds]
        return sum(rewards for rewards, _ in each), sum(contacts for _, contacts in each)

    random, _ = total(lambda env: env.action_space.sample())
    for planner in ("exact", "potential-field"):
        rewards, contacts = total(lambda env, planner=planner: env.baseline(planner))
        assert rewards > 0.25 * random, f"{planner}, seeds {seeds}: {rewards} against {random}"
        assert contacts == 0, f"{planner}, seeds {seeds}"


def test_mistakes_are_named() -> None:
    with pytest.raises(ValueError, match="fidelity: unknown variant `fast`"):
        FlotillaEnv(fidelity="fast")
    with pytest.raises(ValueError, match="duration_s = 0 s: must be from 1"):
        FlotillaEnv(duration_s=0.0)
    with pytest.raises(ValueError, match="no-such"):
        FlotillaEnv(scenario="no-such")
    env = FlotillaEnv(fidelity="cycle")
    with pytest.raises(ValueError, match="reset it first"):
        env.step(env.action_space.sample())
    env.reset(seed=SEED)
    with pytest.raises(ValueError, match="action 4 of environment 0 = NaN"):
        env.step(np.array([0.0, 1.0, 0.0, 0.0, np.nan, 0.0, 0.0, 0.0, 0.0]))
    with pytest.raises(ValueError, match=r"actions has the shape \[1, 8\]: must be \(1, 9\)"):
        env.step(np.zeros(8))
