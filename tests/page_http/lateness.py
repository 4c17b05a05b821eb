#!/usr/bin/env python3
"""Measures how late the daemon's rows are while its page is flooded, and what the flood costs the page.

usage: tests/page_http/lateness.py [--bin build/release/bin] [--rows 300] [--speed 1000] [--clients 200]

Starts `airside serve` (the RC plant, running freely), `airsided` on a clock of the same speed, and `airside-page`, all on
127.0.0.1. Then, for so many rows each: nothing else; a flood (CLIENTS connections at a time from eight addresses, over and
over); slow headers (slowhttptest, 500 connections); slow bodies. Of each it prints the 50th and 99th percentile and the
largest of the row's lateness (began after its instant) and end (committed after its instant), in ms of real time, and
descriptors and memory of airside-page before, during and after. The flood ends with the measurement, at the latest after
ten minutes. All of it shares this machine's processors: the load is printed beside.
"""

import argparse
import json
import multiprocessing
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LONGEST_FLOOD_S = 600


def flood(port, clients, stop, requests):
    """Opens `clients` connections at a time, asks, reads what comes, closes."""
    end = time.monotonic() + LONGEST_FLOOD_S
    request = b"GET /status.json HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    done = 0
    while not stop.is_set() and time.monotonic() < end:
        peers = []
        for i in range(clients):
            peer = socket.socket()
            peer.setblocking(False)
            peer.bind((f"127.0.0.{10 + i % 8}", 0))
            peer.connect_ex(("127.0.0.1", port))
            peers.append(peer)
        until = time.monotonic() + 1
        waiting = {p.fileno(): p for p in peers}
        poll = select.poll()
        for p in peers:
            poll.register(p, select.POLLOUT)
        asked = set()
        while waiting and time.monotonic() < until and not stop.is_set():
            for fd, event in poll.poll(100):
                try:
                    if fd not in asked and event & select.POLLOUT:
                        waiting[fd].send(request)
                        asked.add(fd)
                        poll.modify(fd, select.POLLIN)
                        continue
                    if waiting[fd].recv(65536):
                        done += 1
                        continue
                except OSError:
                    pass
                poll.unregister(fd)
                del waiting[fd]
        for p in peers:
            p.close()
    requests.value += done


class Process:
    def __init__(self, words, log):
        self.log = log
        self.child = subprocess.Popen([str(w) for w in words], stdout=open(log, "a"), stderr=subprocess.STDOUT)

    def end(self):
        if self.child.poll() is None:
            self.child.send_signal(signal.SIGTERM)
        return self.child.wait(30)

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.child.pid}/fd"))

    def memory_kb(self):
        for line in Path(f"/proc/{self.child.pid}/status").read_text().splitlines():
            if line.startswith("RssAnon:"):
                return int(line.split()[1])
        return 0


def first_line(path, process):
    for _ in range(6000):
        if process.child.poll() is not None:
            sys.exit(f"{process.log}: {Path(process.log).read_text()}")
        if path.exists() and path.read_text().endswith("\n"):
            return path.read_text().strip()
        time.sleep(0.01)
    sys.exit(f"{path}: nothing after a minute")


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def watch(status, rows, page):
    """Rows as they come: lateness and end, ms; the most descriptors and memory that the page had meanwhile."""
    late, done, seen, most, kb = [], [], None, 0, 0
    while len(late) < rows:
        time.sleep(0.02)
        most, kb = max(most, page.descriptors()), max(kb, page.memory_kb())
        try:
            now = json.loads(status.read_text())
        except (OSError, ValueError):
            continue
        if now["time"] == seen or now["row_late_ms"] is None:
            continue
        if seen is not None:
            late.append(now["row_late_ms"])
            done.append(now["row_done_ms"])
        seen = now["time"]
    return late, done, most, kb, now


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=Path, default=Path("build/release/bin"))
    parser.add_argument("--rows", type=int, default=300)
    parser.add_argument("--speed", type=float, default=1000)
    parser.add_argument("--clients", type=int, default=200)
    options = parser.parse_args()
    program = {name: (options.bin / name).resolve() for name in ("airside", "airsided", "airside-page")}
    folder = Path(tempfile.mkdtemp(prefix="airside_lateness_"))
    run = lambda *words: subprocess.run([str(w) for w in words], check=True, stdout=subprocess.DEVNULL)
    run(program["airside"], "init", folder / "site")
    site = folder / "site"
    # Without the clock of the plant: the daemon keeps its own.
    rows = (site / "points.csv").read_text().splitlines(keepends=True)
    (site / "points.csv").write_text("".join(r for r in rows if not r.startswith(("clock_s", "clock_advance_s"))))
    run(program["airside"], "pretrain", "--plant", "rc", "--room", "301", "--days", "4", "-o", folder / "room.blob")
    text = (site / "site.toml").read_text().replace('blob = ""', f'blob = "{folder}/room.blob"')

    server = Process([program["airside"], "serve", "--site", site / "site.toml", "--plant", "rc", "--room", "301", "--port",
                      "0", "--speed", options.speed, "--days", "300", "--ready", folder / "served"], folder / "serve.txt")
    port = first_line(folder / "served", server).rsplit(":", 1)[1]
    (site / "site.toml").write_text(text.replace("port = 502", f"port = {port}"))
    daemon = Process([program["airsided"], "--site", site / "site.toml", "--clock-speed", options.speed, "--crash-limit",
                      "0"], folder / "daemon.txt")
    page = Process([program["airside-page"], "--site", site / "site.toml", "--port", "0", "--ready", folder / "page"],
                   folder / "page.txt")
    page_port = int(first_line(folder / "page", page).rsplit(":", 1)[1])
    status = site / "state" / "status.json"
    result = {"speed": options.speed, "rows": options.rows, "processors": os.cpu_count(), "runs": []}
    try:
        watch(status, 20, page)  # the first rows only fill the windows

        def measure(name, attack):
            before = page.descriptors(), page.memory_kb()
            stop = attack() if attack else None
            late, done, most, kb, last = watch(status, options.rows, page)
            requests = stop() if stop else None
            time.sleep(16)
            entry = {"run": name, "late_p50_ms": percentile(late, 0.5), "late_p99_ms": percentile(late, 0.99),
                     "late_max_ms": max(late), "done_p50_ms": percentile(done, 0.5), "done_p99_ms": percentile(done, 0.99),
                     "done_max_ms": max(done), "state": last["state"], "load": os.getloadavg()[0],
                     "page_descriptors": [before[0], most, page.descriptors()],
                     "page_memory_kb": [before[1], kb, page.memory_kb()], "answers": requests}
            result["runs"].append(entry)
            print(json.dumps(entry), flush=True)

        def start_flood():
            stop, count = multiprocessing.Event(), multiprocessing.Value("q", 0)
            worker = multiprocessing.Process(target=flood, args=(page_port, options.clients, stop, count))
            worker.start()

            def end():
                stop.set()
                worker.join()
                return count.value

            return end

        def slow(*words):
            def start():
                attack = subprocess.Popen(["slowhttptest", "-c", "500", "-r", "100", "-l", str(LONGEST_FLOOD_S), "-i", "1",
                                           "-p", "3", "-u", f"http://127.0.0.1:{page_port}/weights", *words],
                                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

                def end():
                    attack.terminate()
                    attack.wait()

                return end

            return start

        measure("undisturbed", None)
        measure("flood", start_flood)
        if shutil.which("slowhttptest"):
            measure("slow headers", slow("-H"))
            measure("slow bodies", slow("-B"))
        measure("undisturbed again", None)
    finally:
        codes = {name: p.end() for name, p in (("page", page), ("daemon", daemon), ("serve", server))}
    print(json.dumps({"exit_codes": codes}))
    shutil.rmtree(folder)


main()
