"""Losses over a batch of scaled (windows, after). Source of the five terms: docs/method.md 4."""

import torch

GAMMA = 0.5
DISCRIMINATOR_WEIGHT = 0.1


def squared(found, wanted):
    return (found - wanted).square().mean()


def method_loss(network, target, windows, after, labels):
    """The published method: short term, long term, gradient and residual constraint, reconstruction."""
    with torch.enable_grad():
        inputs = windows[:, -1].detach().requires_grad_(True)
        short, difference, again = network(inputs)
        slopes, = torch.autograd.grad(short.sum(), inputs, create_graph=True)
    rooms = network.rooms
    now, then = windows[:, -1, :rooms], after[:, :rooms]
    with torch.no_grad():
        held = torch.cat([after, windows[:, -1, -1:]], 1)
        later, change, _ = target(held)
        wanted = GAMMA * (change + later - then)
    return (squared(short, then) + squared(difference, wanted) + torch.relu(-labels * slopes).sum(1).mean()
            + torch.relu(-(then - now) * difference).mean() + squared(again, now))


def plain_loss(network, _target, windows, after, domain=0):
    """Short term and reconstruction: OSLN and FATDM."""
    inputs = windows[:, -1]
    short, again, _ = network.short_term(inputs, domain)
    return squared(short, after[:, :network.rooms]) + squared(again, inputs[:, :network.rooms])


def short_loss(network, _target, windows, after):
    """Short term alone: the identified model of DDQN."""
    return squared(network.short_term(windows[:, -1])[0], after[:, :network.rooms])


def series_loss(network, _target, windows, after):
    """Next room temperatures from a window of cycles: LSTM and Transformer."""
    found = network(windows)
    return squared(found, after[:, :found.shape[1]])


def adversarial_loss(network, discriminator, source, target):
    """DAF: both domains' plain losses, and features in which the domains cannot be told apart."""
    total, told = 0.0, []
    for domain, (windows, after) in enumerate((source, target)):
        inputs = windows[:, -1]
        short, again, features = network.short_term(inputs, domain)
        total = total + squared(short, after[:, :network.rooms]) + squared(again, inputs[:, :network.rooms])
        found = discriminator(features)
        told.append(torch.nn.functional.binary_cross_entropy_with_logits(found, torch.full_like(found, float(domain))))
    return total / 2 + DISCRIMINATOR_WEIGHT * (told[0] + told[1]) / 2
