"""DQN and SAC of Stable-Baselines3: trained on rooms that are drawn anew each episode, scored without learning."""

import gymnasium
import numpy as np
import torch
from airside_gym.scores import Scores
from stable_baselines3 import DQN, SAC
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from .progress import Progress

TWINS = ("301", "401", "402", "701", "702")
STEPS_OF_A_DAY, EXPERT_DAYS = 80, 5
DISCOUNT = 0.95  # a horizon of 20 cycles, 6 h
COMMON = {"gamma": DISCOUNT, "learning_starts": 200, "train_freq": 1, "buffer_size": 100_000, "device": "cpu"}
AGENTS = {
    "dqn": (DQN, {"learning_rate": 1e-3, "batch_size": 64, "target_update_interval": 200, "exploration_fraction": 0.3,
                  "exploration_final_eps": 0.02}),
    "sac": (SAC, {"learning_rate": 1e-3, "batch_size": 128}),
}


class ShowsProgress(BaseCallback):
    def __init__(self, progress):
        super().__init__()
        self.progress = progress

    def _on_step(self):
        self.progress.show(self.num_timesteps)
        return True


class DrawsRooms(gymnasium.Wrapper):
    """Each episode in another twin, from another day of summer on."""

    def reset(self, *, seed=None, options=None):
        rng = np.random.default_rng(seed) if seed is not None else self.unwrapped.np_random
        day = np.datetime64("2021-05-01") + int(rng.integers(120))
        drawn = {"room": str(rng.choice(TWINS)), "start": str(day)}
        return self.env.reset(seed=seed, options={**drawn, **(options or {})})


def make(airside, algorithm, **choices):
    step_k = 0.5 if algorithm == "dqn" else None
    return gymnasium.make("airside/Rc-v0", airside=airside, discrete_step_k=step_k, disable_env_checker=True, **choices)


def trained(options, algorithm, seed):
    """(agent, observation statistics) after options.days simulated days."""
    torch.set_num_threads(1)
    kind, settings = AGENTS[algorithm]
    rooms = DummyVecEnv([lambda: DrawsRooms(make(options.airside, algorithm, days=options.episode_days,
                                                 movement_penalty=options.movement_penalty))])
    scaled = VecNormalize(rooms, norm_reward=False, gamma=DISCOUNT)
    steps = options.steps or options.days * STEPS_OF_A_DAY
    try:
        agent = kind("MlpPolicy", scaled, seed=seed, **COMMON, **settings)
        agent.learn(steps, callback=ShowsProgress(Progress(f"{algorithm}, seed {seed}", steps)))
    finally:
        scaled.close()
    scaled.training = False
    return agent, scaled


def scored(options, algorithm, agent, scaled, room, seed):
    with make(options.airside, algorithm, room=room, days=options.score_days, expert_days=EXPERT_DAYS,
              start=options.start) as env:
        scores = Scores(env.unwrapped.target_degc)
        observation, before = env.reset(seed=seed)
        over = False
        while not over:
            action, _ = agent.predict(scaled.normalize_obs(observation), deterministic=True)
            observation, _, _, over, after = env.step(action)
            scores.add(before, after)
            before = after
    return scores.figures()
