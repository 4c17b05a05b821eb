"""Networks, losses and training of tools/gym/method_peers against the golden vectors; skipped without torch."""

import dataclasses
import importlib.util
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from desk import PROGRAM

ROOT = Path(__file__).resolve().parents[2]
SCRIPT, GOLDEN = ROOT / "tools/gym/method_peers", ROOT / "tests/golden/data"
sys.path.insert(0, str(ROOT / "tools/bench_peers"))
import golden

META = golden.META
NAMES = [f"{kind}{n}" for kind in ("room_temp_", "fcu_temp_", "vav_on_", "fcu_on_") for n in range(1, 6)]
NAMES += ["power_1", "power_2", "mau_temp", "outdoor_temp", "rain"]


def setUpModule():
    if not importlib.util.find_spec("torch"):
        raise unittest.SkipTest("torch is not installed: install it with pip into a Python that has gymnasium, and "
                                "name it in AIRSIDE_GYM_PYTHON. This test checked nothing.")
    import torch

    torch.set_num_threads(1)


def golden_network(name):
    """EdNetwork with the golden weights, double."""
    import torch
    from airside_peers.networks import EdNetwork
    from airside_peers.signals import Layout

    network = EdNetwork(Layout(NAMES)).double()
    torch.nn.utils.vector_to_parameters(torch.from_numpy(golden.flat(golden.weights(name))), network.parameters())
    return network


def golden_batch(count):
    import torch

    table = torch.from_numpy(golden.batch(count))
    return table[:, None, :26], table[:, 26:]


def golden_learner():
    import functools

    import torch
    from airside_peers import losses
    from airside_peers.learner import Learner

    loss = functools.partial(losses.method_loss, labels=torch.tensor(META["labels"], dtype=torch.double))
    learner = Learner(golden_network("weights"), loss)
    learner.target.load_state_dict(golden_network("target_weights").state_dict())
    return learner


class Golden(unittest.TestCase):
    def test_the_loss_is_the_sum_of_the_five_golden_terms(self):
        for count in (1, 32):
            known = json.loads((GOLDEN / f"loss_{count}.json").read_text(encoding="utf-8"))["terms"]["total"]
            self.assertAlmostEqual(golden_learner().surprise(*golden_batch(count)), known, places=11)

    def test_its_gradient_is_the_golden_one(self):
        import torch

        learner = golden_learner()
        learner.loss(learner.network, learner.target, *golden_batch(32)).backward()
        found = torch.cat([parameter.grad.flatten() for parameter in learner.network.parameters()]).numpy()
        np.testing.assert_allclose(found, np.loadtxt(GOLDEN / "grad_total_32.csv"), atol=1e-12)

    def test_twenty_steps_lead_to_the_golden_weights(self):
        import torch
        from airside_peers import learner as module

        learner, batch = golden_learner(), golden_batch(32)
        with mock.patch.object(module, "SYNC_STEPS", 7):
            for _ in range(20):
                learner.step(*batch)
        found = torch.nn.utils.parameters_to_vector(learner.network.parameters()).detach().numpy()
        np.testing.assert_allclose(found, np.loadtxt(GOLDEN / "weights_b32_sync7_step20.csv"), atol=1e-9)


class Parts(unittest.TestCase):
    def layout(self):
        from airside_peers.signals import Layout

        return Layout(NAMES)

    def test_the_replay_forgets_the_oldest_and_draws_each_once(self):
        import torch
        from airside_peers.learner import Replay
        from airside_peers.transitions import Transitions

        def some(first, count):
            values = np.arange(first, first + count, dtype=np.float32)
            return Transitions(np.tile(values[:, None, None], (1, 2, 3)), np.tile(values[:, None], (1, 4)))

        replay = Replay(some(0, 5), capacity=6)
        more = some(5, 3)
        replay.add(torch.from_numpy(more.windows), torch.from_numpy(more.after))
        windows, after = replay.draw(100)
        self.assertEqual(sorted(after[:, 0].tolist()), [2, 3, 4, 5, 6, 7])
        self.assertTrue((windows[:, 1, 2] == after[:, 3]).all())

    def test_networks_have_the_shapes_of_the_study(self):
        import torch
        from airside_peers.networks import LstmNetwork, TransformerNetwork

        for length, depth in ((2, 2), (6, 4)):
            windows = torch.randn(7, length, 26)
            for network in (LstmNetwork(self.layout(), depth), TransformerNetwork(self.layout(), length, depth)):
                self.assertEqual(network(windows).shape, (7, 5))
                moved = windows.clone()
                moved[:, 0] += 1
                self.assertTrue((network(moved) != network(windows)).any())  # the oldest cycle counts

    def test_fatdm_leaves_its_layers_alone(self):
        from airside_peers import losses, transfer
        from airside_peers.networks import EdNetwork
        from airside_peers.transitions import Transitions

        data = Transitions(np.random.default_rng(1).normal(size=(50, 1, 26)).astype(np.float32),
                           np.random.default_rng(2).normal(size=(50, 25)).astype(np.float32))
        for method, count in (("fatdm-head", 4), ("fatdm-tail", 2), ("static", 0)):
            network = EdNetwork(self.layout())
            frozen = transfer.frozen_in(method, network)
            before = {name: value.detach().clone() for name, value in network.named_parameters()}
            transfer._train(network, losses.plain_loss, data, 3, lambda _: None, frozen)
            fixed = {id(parameter) for parameter in frozen}
            self.assertEqual(len(fixed), count)
            for name, value in network.named_parameters():
                if not name.startswith("long_branch"):
                    self.assertEqual(bool((before[name] == value).all()), id(value) in fixed, (method, name))

    def test_the_discriminator_s_gradient_is_reversed_before_it_alone(self):
        import torch
        from airside_peers.networks import Discriminator

        torch.manual_seed(1)
        discriminator, features = Discriminator(), torch.randn(4, 64, requires_grad=True)
        discriminator(features).sum().backward()
        plain = features.detach().clone().requires_grad_(True)
        discriminator.layers(plain)[:, 0].sum().backward()
        self.assertTrue(torch.equal(features.grad, -plain.grad))

    def test_synthetic_copies_follow_the_rule(self):
        from airside_peers.agents import with_synthetic
        from airside_peers.transitions import Scaler, Transitions

        layout = self.layout()
        scaler = Scaler(layout, np.random.default_rng(3).normal(20, 2, (240, 26)))
        made = with_synthetic(Transitions(np.zeros((3, 1, 26), np.float32), np.zeros((3, 25), np.float32)), layout,
                              scaler, 1)
        change_k = made.windows[:, 0, -1] * scaler.scale[-1]
        np.testing.assert_allclose(change_k, np.repeat([0, -2, -1, 1, 2], 3), atol=1e-5)
        rises = made.after[3:, 0] * scaler.scale[0] / change_k[3:]
        self.assertTrue(((0.1 <= rises) & (rises <= 0.3)).all())
        self.assertFalse(made.after[:, 5:].any())

    def test_double_q_learning_finds_the_better_action(self):
        import torch
        from airside_peers.q_agent import QLearner

        torch.manual_seed(1)
        learner, rng = QLearner(3, 2), np.random.default_rng(1)
        for _ in range(1500):
            before, action = torch.tensor(rng.normal(size=3), dtype=torch.float32), int(rng.integers(2))
            better = action == int(before[0] > 0)
            learner.remember(before, action, float(better) - 1, torch.tensor(rng.normal(size=3), dtype=torch.float32))
            learner.step()
        self.assertEqual([learner.best(torch.tensor([x, 0.0, 0.0])) for x in (-1, 1)], [0, 1])


class Short(unittest.TestCase):
    """Runs that are too short to mean anything."""

    def setUp(self):
        from airside_peers import agents, control, q_agent, transfer

        for module, name, value in ((agents, "FIRST_STEPS", 40), (control, "FIRST_STEPS", 40),
                                    (q_agent, "MODEL_STEPS", 40), (q_agent, "EPISODES", 5),
                                    (transfer, "FINE_TUNING_STEPS", 20)):
            patched = mock.patch.object(module, name, value)
            patched.start()
            self.addCleanup(patched.stop)

    def test_every_kind_of_agent_controls_a_room(self):
        from airside_peers.control import Controlled
        from airside_peers.runs import Run

        settings = (("from", "2021-08-01"), ("days", 1), ("updates", 1), ("batch", 64))
        for method in ("ddqn", "osln", "ed", "lstm-2-2", "transformer-3-2"):
            shares = []
            run = Run("control", "rc", "301-real", method, 1, settings)
            first, again = (Controlled(PROGRAM, run, shares.append).figures() for _ in range(2))
            self.assertTrue(0 < first["dae_degc"] < 5 and first["decision_s"] > 0, (method, first))
            self.assertEqual(first["daily_dae_degc"], again["daily_dae_degc"])  # the same seed gives the same run
            self.assertEqual(shares[-1], 1)
            other = Controlled(PROGRAM, dataclasses.replace(run, seed=2), shares.append).figures()
            self.assertNotEqual(first["dae_degc"], other["dae_degc"])

    def test_every_way_of_transfer_is_tested_on_both_seasons(self):
        from airside_peers import runs, transfer

        settings = (("source", 2), ("steps", 20), ("summer", 2), ("winter", 2))
        with tempfile.TemporaryDirectory() as folder:
            def figures(method, *more):
                run = runs.Run("transfer", "rc", "701-real", method, 1, (*settings, *more))
                return transfer.figures_of(PROGRAM, folder, run, lambda share: self.assertLessEqual(share, 1))

            found = {method: figures(method) for method in runs.TRANSFER_COST}
            season = figures("static", ("adapt", "season"))
        self.assertEqual(len({figures["mae_summer_degc"] for figures in found.values()}), len(found))
        for figures in found.values():
            self.assertEqual((figures["transitions_summer"], figures["transitions_winter"]), (159, 159))
        self.assertEqual(season["mae_summer_degc"], found["static"]["mae_summer_degc"])
        self.assertNotEqual(season["mae_winter_degc"], found["static"]["mae_winter_degc"])

    def test_the_command_line_runs_networks_too(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-B", SCRIPT, "control", "--airside", PROGRAM, "--results", folder,
                                   "--methods", "ed", "--seeds", "1", "--days", "1", "--updates", "1", "--batch", "16",
                                   "--json"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        row, = json.loads(done.stdout)["rows"]
        self.assertEqual((row["method"], row["runs"]), ("ed", 1))


if __name__ == "__main__":
    unittest.main()
