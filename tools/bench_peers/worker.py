"""One peer in a process of its own: says that it is ready, then times what its standard input asks for.

worker.py NAME       lines "kind count seconds" in; one JSON line a measurement out, and one at the start
"""

import json
import resource
import statistics
import sys
import time

from graphs import LiteRt, OnnxRuntime
from peers import KINDS, Jax, JaxAutograd, Numpy, TorchAutograd, TorchClosed, TorchCompiled

PEERS = {
    "numpy": Numpy,
    "torch": TorchClosed,
    "torch-autograd": TorchAutograd,
    "torch-compile": TorchCompiled,
    "jax": Jax,
    "jax-autograd": JaxAutograd,
    "onnxruntime": OnnxRuntime,
    "litert": LiteRt,
}


def say(**line):
    print(json.dumps(line), flush=True)


def timed(work, seconds):
    clock, times, until = time.perf_counter_ns, [], time.perf_counter() + seconds
    while len(times) < 15 or (time.perf_counter() < until and len(times) < 20000):
        begin = clock()
        work()
        times.append((clock() - begin) / 1e3)
    return times


def main():
    peer = PEERS[sys.argv[1]]()
    error = peer.check()
    works = {(kind, count): peer.work(kind, count) for kind in peer.kinds for count in KINDS[kind]}
    for work in works.values():
        for _ in range(5):
            work()
    say(version=peer.version(), what=peer.what, error=error, kinds=[list(key) for key in works])
    for line in sys.stdin:
        kind, count, seconds = line.split()
        times = timed(works[kind, int(count)], float(seconds))
        say(
            median_us=statistics.median(times),
            min_us=min(times),
            runs=len(times),
            rss_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        )


if __name__ == "__main__":
    main()
