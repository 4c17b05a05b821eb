"""The published network and its gradient by hand, for any library of arrays: no autograd, so that peers start equal.

`ops` gives joined(parts) along columns and where(condition, a, b); weights are [(W, b)] in the order of golden.LAYERS.
Equations: docs/method.md 3 and 4."""

from golden import LAYERS, ROOMS, SIGNALS

PLACE = {name: n for n, (name, _, _) in enumerate(LAYERS)}
LEAK, GAMMA = 0.2, 0.5
SHARED = ("share.0", "share.1", "share.2")


class Pass:
    """One forward pass; keeps what each layer was given and the slope of its LeakyReLU."""

    def __init__(self, ops, weights):
        self.ops, self.weights, self.seen = ops, weights, {}

    def layer(self, name, x):
        w, b = self.weights[PLACE[name]]
        z = x @ w.T + b
        slope = self.ops.where(z > 0, 1.0, LEAK)
        self.seen[name] = (x, slope)
        return z * slope

    def chain(self, names, x):
        for name in names:
            x = self.layer(name, x)
        return x

    def branches(self, state, action):
        """(f_short, f_res)."""
        latent = self.chain(SHARED, self.ops.joined([state, action]))
        return self.chain(("strb.0", "strb.1"), latent), self.chain(("tdb.0", "tdb.1"), latent)

    def features(self, inputs):
        """(f_S, f_short, f_res)."""
        state = self.chain(("enc_s.0", "enc_s.1"), inputs[:, :SIGNALS])
        action = self.chain(("enc_a.0", "enc_a.1"), inputs[:, ROOMS:])
        return state, *self.branches(state, action)

    def back(self, names, d, gradient):
        """Carries d(loss)/d(output) back through the layers `names`, last first; adds to `gradient`."""
        for name in names:
            x, slope = self.seen[name]
            d = d * slope
            gradient[PLACE[name]] = (d.T @ x, d.sum(0))
            d = d @ self.weights[PLACE[name]][0]
        return d

    def slopes(self, names, d, kept):
        """The same without gradients; keeps d before each layer's weights."""
        for name in names:
            kept[name] = d * self.seen[name][1]
            d = kept[name] @ self.weights[PLACE[name]][0]
        return d

    def tangent(self, names, t, kept, gradient):
        """Carries a change of the inputs forward; adds d(sum S' change)/dW to `gradient`."""
        for name in names:
            w, b = gradient[PLACE[name]]
            gradient[PLACE[name]] = (w + kept[name].T @ t, b)
            t = (t @ self.weights[PLACE[name]][0].T) * self.seen[name][1]
        return t


def graph(ops, weights, inputs):
    """(S', D', reconstruction of S)."""
    state, short, residual = Pass(ops, weights).features(inputs)
    w, b = weights[PLACE["dec"]]
    return short @ w.T + b, residual @ w.T, state @ w.T + b


def decide(ops, weights, signals, setpoints, repeated):
    """(S', D') of many setpoints in one state: the state is encoded once. repeated(row, n): n times that row."""
    run, count = Pass(ops, weights), setpoints.shape[0]
    state = run.chain(("enc_s.0", "enc_s.1"), signals)
    action = run.chain(("enc_a.0", "enc_a.1"), ops.joined([repeated(signals[:, ROOMS:], count), setpoints]))
    short, residual = run.branches(repeated(state, count), action)
    w, b = weights[PLACE["dec"]]
    return short @ w.T + b, residual @ w.T


def wanted(ops, target, rows):
    """The bootstrapped target of D'."""
    later, change, _ = graph(ops, target, ops.joined([rows[:, SIGNALS + 1 :], rows[:, SIGNALS : SIGNALS + 1]]))
    return GAMMA * (change + later - rows[:, SIGNALS + 1 : SIGNALS + 1 + ROOMS])


def gradient(ops, weights, target, rows, labels):
    """[(dW, db)] of the sum of all five losses over a batch."""
    inputs, now, then = rows[:, : SIGNALS + 1], rows[:, :ROOMS], rows[:, SIGNALS + 1 : SIGNALS + 1 + ROOMS]
    each = 1.0 / (ROOMS * rows.shape[0])
    run, out = Pass(ops, weights), [None] * len(LAYERS)
    state, short, residual = run.features(inputs)
    w, b = weights[PLACE["dec"]]
    difference, moved = residual @ w.T, then - now
    d_short = 2 * each * (short @ w.T + b - then)
    d_again = 2 * each * (state @ w.T + b - now)
    d_difference = each * (
        2 * (difference - wanted(ops, target, rows)) + ops.where(moved * difference < 0, -moved, 0.0)
    )

    d_latent = run.back(("strb.1", "strb.0"), d_short @ w, out) + run.back(("tdb.1", "tdb.0"), d_difference @ w, out)
    d_joint = run.back(SHARED[::-1], d_latent, out)
    half = state.shape[1]
    run.back(("enc_s.1", "enc_s.0"), d_joint[:, :half] + d_again @ w, out)
    run.back(("enc_a.1", "enc_a.0"), d_joint[:, half:], out)

    kept = {}
    g_joint = run.slopes(("strb.1", "strb.0", *SHARED[::-1]), ops.repeated(w.sum(0)[None, :], rows.shape[0]), kept)
    g_state = run.slopes(("enc_s.1", "enc_s.0"), g_joint[:, :half], kept)
    g_action = run.slopes(("enc_a.1", "enc_a.0"), g_joint[:, half:], kept)
    slope = ops.joined([g_state[:, :ROOMS], g_state[:, ROOMS:] + g_action[:, :-1], g_action[:, -1:]])
    change = ops.where(labels * slope < 0, -labels, 0.0) / rows.shape[0]
    t = ops.joined(
        [
            run.tangent(("enc_s.0", "enc_s.1"), change[:, :SIGNALS], kept, out),
            run.tangent(("enc_a.0", "enc_a.1"), change[:, ROOMS:], kept, out),
        ]
    )
    t = run.tangent((*SHARED, "strb.0", "strb.1"), t, kept, out)
    out[PLACE["dec"]] = (
        d_short.T @ short + d_difference.T @ residual + d_again.T @ state + t.sum(0)[None, :],
        (d_short + d_again).sum(0),
    )
    return out
