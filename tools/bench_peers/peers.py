"""The peers: each gives work(kind, count) -> a call to be timed, for the kinds it has, and checks itself before.

graph  S', D' and the reconstruction of `count` rows
decide S' and D' of `count` setpoints in one state, whose encoder runs once
step   all five losses of `count` rows, their gradients, Adam; at learning rate 0, so that each step has the same work
"""

import importlib.metadata

import closed_form
import golden
import numpy as np

KINDS = {"graph": (1, 46), "decide": (1, 46), "step": (32, 128, 1000)}
BETA_1, BETA_2, EPSILON, RATE = 0.9, 0.999, 1e-8, 0.0
ALLOWED = 2e-5  # of golden values up to 8, in float


def single(values):
    return np.ascontiguousarray(values, dtype=np.float32)


class NumpyOps:
    @staticmethod
    def joined(parts):
        return np.concatenate(parts, 1)

    @staticmethod
    def where(condition, a, b):
        return np.where(condition, np.float32(a) if np.isscalar(a) else a, np.float32(b) if np.isscalar(b) else b)

    @staticmethod
    def repeated(row, count):
        return np.repeat(row, count, 0)


class Peer:
    """What all have: golden weights, rows, and the check."""

    package, kinds, what = "numpy", ("graph", "decide", "step"), ""

    def __init__(self):
        self.weights = [(single(w), single(b)) for w, b in golden.weights("weights")]
        self.target = [(single(w), single(b)) for w, b in golden.weights("target_weights")]
        self.rows, self.labels = single(golden.batch(1000)), single(golden.LABELS)
        self.start()

    def version(self):
        return f"{self.package} {importlib.metadata.version(self.package)}"

    def inputs(self, count):
        return self.rows[:count, : golden.INPUTS].copy()

    def state(self):
        return self.rows[:1, : golden.SIGNALS].copy()

    def setpoints(self, count):
        return single(np.arange(count)[:, None] * 0.05 - 1.5)

    def work(self, kind, count):
        return getattr(self, kind)(count)

    def check(self):
        """The largest error against the golden vectors; refuses a peer that does other work."""
        worst = 0.0
        if "graph" in self.kinds:
            worst = max(worst, self.error_of("graph", 46, closed_form.graph(NumpyOps, self.weights, self.inputs(46))))
        if "decide" in self.kinds:
            for count in KINDS["decide"]:
                known = closed_form.decide(
                    NumpyOps, self.weights, self.state(), self.setpoints(count), NumpyOps.repeated
                )
                worst = max(worst, self.error_of("decide", count, known))
        if "step" in self.kinds:
            found = golden.flat([(np.asarray(w), np.asarray(b)) for w, b in self.gradient(single(golden.batch(32)))])
            worst = max(worst, float(abs(found - golden.gradient_of_32()).max()))
        if not worst < ALLOWED:
            raise SystemExit(
                f"{type(self).__name__}: differs by {worst:.1e} from the golden vectors; "
                f"expected below {ALLOWED:.0e}: it would be timed for other work"
            )
        return worst

    def error_of(self, kind, count, known):
        found = self.work(kind, count)()
        return max(float(abs(np.asarray(f) - k).max()) for f, k in zip(found, known))


class Numpy(Peer):
    what = "gradient by hand, OpenBLAS"

    def start(self):
        self.flat = single(golden.flat(self.weights))
        self.m, self.v, self.k = np.zeros_like(self.flat), np.zeros_like(self.flat), 0

    def graph(self, count):
        x = self.inputs(count)
        return lambda: closed_form.graph(NumpyOps, self.weights, x)

    def decide(self, count):
        state, setpoints = self.state(), self.setpoints(count)
        return lambda: closed_form.decide(NumpyOps, self.weights, state, setpoints, NumpyOps.repeated)

    def gradient(self, rows):
        return closed_form.gradient(NumpyOps, self.weights, self.target, rows, self.labels)

    def step(self, count):
        rows, f = self.rows[:count].copy(), np.float32

        def one():
            self.k += 1
            g = golden.flat(self.gradient(rows))
            self.m[:] = f(BETA_1) * self.m + f(1 - BETA_1) * g
            self.v[:] = f(BETA_2) * self.v + f(1 - BETA_2) * g * g
            scale = f(1 / (1 - BETA_2**self.k))
            self.flat -= f(RATE / (1 - BETA_1**self.k)) * self.m / (np.sqrt(self.v * scale) + f(EPSILON))
            return self.flat

        return one


class TorchClosed(Peer):
    """No autograd."""

    package, kinds, what = "torch", ("graph", "decide", "step"), "eager, gradient by hand"

    def start(self):
        import torch

        torch.set_num_threads(1)
        self.torch = torch
        torch.set_grad_enabled(False)

        class Ops:
            where = staticmethod(torch.where)

            @staticmethod
            def joined(parts):
                return torch.cat(parts, 1)

            @staticmethod
            def repeated(row, count):
                return row.expand(count, -1)

        self.ops = Ops
        pairs = ([(torch.from_numpy(w), torch.from_numpy(b)) for w, b in net] for net in (self.weights, self.target))
        self.tensors, self.held = pairs
        self.lab = torch.from_numpy(self.labels)
        self.flat = torch.cat([t.reshape(-1) for pair in self.tensors for t in pair])
        self.m, self.v, self.k = torch.zeros_like(self.flat), torch.zeros_like(self.flat), 0

    def compiled(self, function):
        return function

    def graph(self, count):
        x = self.torch.from_numpy(self.inputs(count))
        run = self.compiled(lambda x: closed_form.graph(self.ops, self.tensors, x))
        return lambda: run(x)

    def decide(self, count):
        state, setpoints = self.torch.from_numpy(self.state()), self.torch.from_numpy(self.setpoints(count))
        run = self.compiled(lambda s, a: closed_form.decide(self.ops, self.tensors, s, a, self.ops.repeated))
        return lambda: run(state, setpoints)

    def gradient(self, rows):
        run = self.compiled(lambda rows: closed_form.gradient(self.ops, self.tensors, self.held, rows, self.lab))
        return run(self.torch.from_numpy(rows))

    def step(self, count):
        rows = self.torch.from_numpy(self.rows[:count].copy())

        def update(flat, m, v, rows, scale):
            g = closed_form.gradient(self.ops, self.tensors, self.held, rows, self.lab)
            g = self.torch.cat([t.reshape(-1) for pair in g for t in pair])
            m.mul_(BETA_1).add_((1 - BETA_1) * g)
            v.mul_(BETA_2).add_((1 - BETA_2) * g * g)
            flat.sub_(RATE * scale[0] * m / ((v * scale[1]).sqrt() + EPSILON))
            return flat

        run = self.compiled(update)

        def one():
            self.k += 1
            scale = self.torch.tensor([1 / (1 - BETA_1**self.k), 1 / (1 - BETA_2**self.k)])
            return run(self.flat, self.m, self.v, rows, scale)

        return one


class TorchCompiled(TorchClosed):
    what = "torch.compile, gradient by hand"

    def compiled(self, function):
        self.torch._dynamo.reset()
        return self.torch.compile(function, dynamic=False)


class TorchAutograd(TorchClosed):
    """As one would write it: autograd, the constraint by a second derivative, torch.optim.Adam."""

    kinds, what = ("step",), "eager, autograd, Adam fused"

    def start(self):
        super().start()
        for pair in self.tensors:
            for t in pair:
                t.requires_grad_(True)
        self.parameters = [t for pair in self.tensors for t in pair]
        self.adam = self.torch.optim.Adam(self.parameters, lr=RATE, fused=True)

    def loss(self, rows):
        torch, r = self.torch, golden.ROOMS
        inputs = rows[:, : golden.INPUTS].detach().requires_grad_(True)
        now, then = rows[:, :r], rows[:, golden.INPUTS : golden.INPUTS + r]
        short, difference, again = closed_form.graph(self.ops, self.tensors, inputs)
        (slopes,) = torch.autograd.grad(short.sum(), inputs, create_graph=True)
        with torch.no_grad():
            wanted = closed_form.wanted(self.ops, self.held, rows)
        return (
            (short - then).square().mean()
            + (difference - wanted).square().mean()
            + (again - now).square().mean()
            + torch.relu(-self.lab * slopes).sum(1).mean()
            + torch.relu(-(then - now) * difference).mean()
        )

    def gradient(self, rows):
        with self.torch.enable_grad():
            found = self.torch.autograd.grad(self.loss(self.torch.from_numpy(rows)), self.parameters)
        return list(zip(found[::2], found[1::2]))

    def step(self, count):
        rows = self.torch.from_numpy(self.rows[:count].copy())

        def one():
            with self.torch.enable_grad():
                self.adam.zero_grad(set_to_none=True)
                loss = self.loss(rows)
                loss.backward()
            self.adam.step()
            return loss

        return one


class Jax(Peer):
    package, what = "jax", "jit, gradient by hand"

    def start(self):
        import jax
        import jax.numpy as jnp

        self.jax, self.jnp = jax, jnp

        class Ops:
            where = staticmethod(jnp.where)

            @staticmethod
            def joined(parts):
                return jnp.concatenate(parts, 1)

            @staticmethod
            def repeated(row, count):
                return jnp.broadcast_to(row, (count, row.shape[1]))

        self.ops = Ops
        self.arrays = [(jnp.asarray(w), jnp.asarray(b)) for w, b in self.weights]
        self.held = [(jnp.asarray(w), jnp.asarray(b)) for w, b in self.target]

    def waits(self, run, *given):
        return lambda: self.jax.block_until_ready(run(*given))

    def graph(self, count):
        run = self.jax.jit(lambda w, x: closed_form.graph(self.ops, w, x))
        return self.waits(run, self.arrays, self.jnp.asarray(self.inputs(count)))

    def decide(self, count):
        run = self.jax.jit(lambda w, s, a: closed_form.decide(self.ops, w, s, a, self.ops.repeated))
        return self.waits(run, self.arrays, self.jnp.asarray(self.state()), self.jnp.asarray(self.setpoints(count)))

    def gradient(self, rows):
        return self.jax.jit(self.gradient_of)(self.arrays, self.held, self.jnp.asarray(rows))

    def gradient_of(self, weights, held, rows):
        return closed_form.gradient(self.ops, weights, held, rows, self.labels)

    def step(self, count):
        jnp, over = self.jnp, self.jax.tree_util.tree_map

        def update(weights, m, v, k, held, rows):
            g, k = self.gradient_of(weights, held, rows), k + 1
            m = over(lambda a, g: BETA_1 * a + (1 - BETA_1) * g, m, g)
            v = over(lambda a, g: BETA_2 * a + (1 - BETA_2) * g * g, v, g)
            rate, scale = RATE / (1 - BETA_1**k), 1 / (1 - BETA_2**k)
            return over(lambda w, a, c: w - rate * a / (jnp.sqrt(c * scale) + EPSILON), weights, m, v), m, v, k

        run = self.jax.jit(update, donate_argnums=(0, 1, 2, 3))
        zero = over(jnp.zeros_like, self.arrays)
        now = [over(jnp.array, self.arrays), zero, over(jnp.array, zero), jnp.float32(0)]
        rows = jnp.asarray(self.rows[:count])

        def one():
            now[:] = run(*now, self.held, rows)
            self.jax.block_until_ready(now[0])

        return one


class JaxAutograd(Jax):
    kinds, what = ("step",), "jit, gradient of a gradient"

    def loss(self, weights, held, rows):
        jax, jnp, r = self.jax, self.jnp, golden.ROOMS
        inputs, now, then = rows[:, : golden.INPUTS], rows[:, :r], rows[:, golden.INPUTS : golden.INPUTS + r]
        short, difference, again = closed_form.graph(self.ops, weights, inputs)
        slopes = jax.grad(lambda x: closed_form.graph(self.ops, weights, x)[0].sum())(inputs)
        wanted = jax.lax.stop_gradient(closed_form.wanted(self.ops, held, rows))
        return (
            ((short - then) ** 2).mean()
            + ((difference - wanted) ** 2).mean()
            + ((again - now) ** 2).mean()
            + jnp.maximum(-self.labels * slopes, 0).sum(1).mean()
            + jnp.maximum(-(then - now) * difference, 0).mean()
        )

    def gradient_of(self, weights, held, rows):
        return self.jax.grad(self.loss)(weights, held, rows)
