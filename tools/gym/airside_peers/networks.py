"""Networks in PyTorch. Weights begin uniform in +-1/sqrt(fan_in), which is the default of torch.nn.Linear."""

import torch
from torch import nn


def layers(*widths):
    stack = []
    for inputs, outputs in zip(widths, widths[1:]):
        stack += [nn.Linear(inputs, outputs), nn.LeakyReLU(0.2)]
    return nn.Sequential(*stack)


class EdNetwork(nn.Module):
    """Encoders and decoder of docs/method.md 3.2. domains: decoders side by side, one for each domain of DAF."""

    def __init__(self, layout, domains=1):
        super().__init__()
        self.rooms, self.readings = layout.rooms, layout.rooms + layout.exogenous
        self.state_encoder = layers(self.readings, 32, 32)
        self.action_encoder = layers(layout.exogenous + 1, 32, 32)
        self.shared = layers(64, 64, 64, 64)
        self.short_branch = layers(64, 64, 32)
        self.long_branch = layers(64, 64, 32)
        self.decoders = nn.ModuleList(nn.Linear(32, layout.rooms) for _ in range(domains))

    def encoded(self, inputs):
        return self.state_encoder(inputs[:, :self.readings]), self.action_encoder(inputs[:, self.rooms:])

    def forward(self, inputs):
        """(S', D', reconstruction of S)."""
        state, action = self.encoded(inputs)
        latent = self.shared(torch.cat([state, action], 1))
        short, decoder = self.short_branch(latent), self.decoders[0]
        return decoder(short), self.long_branch(latent) @ decoder.weight.T, decoder(state)

    def short_term(self, inputs, domain=0):
        """(S', reconstruction of S, features) without the long-term branch."""
        state, action = self.encoded(inputs)
        features = torch.cat([state, action], 1)
        decoder = self.decoders[domain]
        return decoder(self.short_branch(self.shared(features))), decoder(state), features


class LstmNetwork(nn.Module):
    def __init__(self, layout, depth, width=64):
        super().__init__()
        self.recurrent = nn.LSTM(layout.width, width, depth, batch_first=True)
        self.out = nn.Linear(width, layout.rooms)

    def forward(self, windows):
        return self.out(self.recurrent(windows)[0][:, -1])


class TransformerNetwork(nn.Module):
    """Encoder only: learned positions, four heads, no dropout; the newest token is decoded."""

    def __init__(self, layout, length, depth, width=64):
        super().__init__()
        self.into = nn.Linear(layout.width, width)
        self.positions = nn.Parameter(0.02 * torch.randn(length, width))
        layer = nn.TransformerEncoderLayer(width, 4, 128, dropout=0.0, batch_first=True)
        self.encoder = nn.TransformerEncoder(layer, depth, enable_nested_tensor=False)
        self.out = nn.Linear(width, layout.rooms)

    def forward(self, windows):
        return self.out(self.encoder(self.into(windows) + self.positions)[:, -1])


class _ReversedGradient(torch.autograd.Function):
    @staticmethod
    def forward(ctx, values):
        return values.view_as(values)

    @staticmethod
    def backward(ctx, gradient):
        return -gradient


class Discriminator(nn.Module):
    """Source or target? What is before it learns to hide that."""

    def __init__(self):
        super().__init__()
        self.layers = nn.Sequential(layers(64, 64, 32), nn.Linear(32, 1))

    def forward(self, features):
        return self.layers(_ReversedGradient.apply(features))[:, 0]
