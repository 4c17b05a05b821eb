"""Transfer peers: one-step error on a season's log, frozen after five days of the target room's schedule."""

import functools

import numpy as np
import torch

from . import losses
from .learner import Learner, Replay
from .networks import Discriminator, EdNetwork
from .seasons import SEASONS, Logs, source_transitions
from .transitions import Scaler, Transitions, transitions_of

FINE_TUNING_STEPS = 3000


def figures_of(program, folder, run, show):
    """{mae_summer_degc, mae_winter_degc}. show: of the share of the run that is done."""
    logs, settings = Logs(program, folder, run), dict(run.settings)
    adapted = list(SEASONS) if settings.get("adapt") == "season" else list(SEASONS)[:1]
    fitted, found = {}, {}
    for place, season in enumerate(adapted):
        torch.manual_seed(run.seed)
        fitted[season] = _predictor(run, logs, *logs.schedule(season),
                                    lambda share, first=place: show((first + share) / len(adapted)))
    for season in SEASONS:
        predict, scaler, layout = fitted[season if season in fitted else adapted[0]]
        tested = transitions_of(logs.season(season), scaler, aligned=True)
        found[f"mae_{season}_degc"] = _mae_degc(predict, scaler, layout, tested)
        found[f"transitions_{season}"] = len(tested)
    return found


def _predictor(run, logs, layout, rows, show):
    """(function from scaled inputs to scaled rooms, scaler, layout)."""
    if run.method == "persistence":
        return lambda inputs: inputs[:, :layout.rooms], Scaler(layout, rows), layout
    steps = dict(run.settings)["steps"]
    if run.method == "none":
        network, scaler = EdNetwork(layout), Scaler(layout, rows)
        _train(network, _whole(layout), transitions_of(rows, scaler), FINE_TUNING_STEPS, show)
        return _short_term(network), scaler, layout
    if run.method == "daf":
        return *_adversarial(layout, logs, rows, steps + FINE_TUNING_STEPS, show), layout
    return *_fine_tuned(run.method, layout, logs, rows, steps, show), layout


def _fine_tuned(method, layout, logs, rows, steps, show):
    """Pretrained on a log of the twin, then fine-tuned on the schedule's days."""
    loss = losses.plain_loss if method.startswith("fatdm") else _whole(layout)
    scaler, source = source_transitions(logs, "dynamic" if method == "dynamic" else "static")
    network, share = EdNetwork(layout), steps / (steps + FINE_TUNING_STEPS)
    _train(network, loss, source, steps, lambda done: show(done * share))
    _train(network, loss, transitions_of(rows, scaler), FINE_TUNING_STEPS,
           lambda done: show(share + done * (1 - share)), frozen_in(method, network))
    return _short_term(network), scaler


def frozen_in(method, network):
    """Parameters that fine-tuning leaves alone: of FATDM the first layers (head) or the last one (tail)."""
    if method == "fatdm-head":
        return [*network.state_encoder[0].parameters(), *network.action_encoder[0].parameters()]
    return [*network.decoders.parameters()] if method == "fatdm-tail" else []


def _whole(layout):
    return functools.partial(losses.method_loss, labels=torch.from_numpy(layout.labels))


def _train(network, loss, transitions, steps, show, frozen=()):
    """show: of the share of these steps."""
    fixed = {id(parameter) for parameter in frozen}
    trained = [parameter for parameter in network.parameters() if id(parameter) not in fixed]
    Learner(network, loss, trained).train(Replay(transitions), steps, lambda done: show(done / steps))


def _short_term(network, domain=0):
    return lambda inputs: network.short_term(inputs, domain)[0]


def _adversarial(layout, logs, rows, steps, show):
    """DAF: both domains together from the first step on, half a batch of each."""
    scaler, source = source_transitions(logs, "static")
    replays = Replay(source), Replay(transitions_of(rows, scaler))
    network, discriminator = EdNetwork(layout, domains=2), Discriminator()
    learner = Learner(torch.nn.ModuleList([network, discriminator]), _adversarial_loss)
    for done in range(steps):
        learner.step(replays[0].draw(500), replays[1].draw(500))
        if done % 20 == 19:
            show((done + 1) / steps)
    return _short_term(network, domain=1), scaler


def _adversarial_loss(networks, _target, source, target):
    return losses.adversarial_loss(networks[0], networks[1], source, target)


@torch.no_grad()
def _mae_degc(predict, scaler, layout, tested: Transitions):
    found = predict(torch.from_numpy(tested.windows[:, -1])).numpy().astype(np.float64)
    return float(np.abs(found - tested.after[:, :layout.rooms]).mean() * scaler.scale[0])
