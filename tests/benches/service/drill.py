"""The alerts of `deploy/prometheus` against faults that are provoked: a real Prometheus watches real servers, and for
each fault exactly its alert has to fire; then ordinary load, during which none may.

Needs `prometheus` (Debian: apt install prometheus); where it is not there nothing is tried, which is said. `--factor`
divides every time of the rules, so that a drill takes minutes; 1 are the rules as shipped. Faults that need what this
machine does not allow (root, NATS, a compiler) are left out, and why is said. `--only` chooses faults by their words,
`--together` says how many are provoked at one time, `--minutes` how long the ordinary load goes on (0: not at all).

    python drill.py --factor 30 --together 4 --minutes 10
"""
import shutil
import sys

if not shutil.which("prometheus"):
    print("drill: left out, because there is no `prometheus` here")
    sys.exit(0)

import contextlib  # noqa: E402
import random  # noqa: E402
import threading  # noqa: E402
import time  # noqa: E402
from concurrent.futures import ThreadPoolExecutor  # noqa: E402

import grpc  # noqa: E402

import common  # noqa: E402
import faults  # noqa: E402, F401
import spoilt  # noqa: E402, F401
import trial  # noqa: E402
from common import Block, attached, session_pb  # noqa: E402
from watching import Prometheus  # noqa: E402

# Longest time until an alert, and how long is waited for others, in seconds of the rules as shipped: rates over ten
# minutes that last for ten more; a look, an evaluation.
LATEST, AFTERWARDS = 25 * 60, 5 * 60
# What does not shrink with the rules: the servers' own times, and a busy machine.
SLACK = 60.0


def drill(prometheus, number, fault):
    """Provokes one fault; true if its alert fired and no other."""
    what, alert, word, provoke = fault
    site = trial.Site(prometheus, number)
    runs = threading.Thread(target=provoked, args=(site, provoke), daemon=True)
    runs.start()
    wanted = (alert, word)
    try:
        when = wait_for(site, wanted)
        if when:
            time.sleep(max(AFTERWARDS / prometheus.factor, 5.0))
    finally:
        site.over.set()
        runs.join(60)
        site.clear()
    if isinstance(site.failed, trial.LeftOut):
        return common.row(what, alert, f"left out: {site.failed}", None)
    fired = {name for name in prometheus.fired(site.observed.page)} if site.observed else set()
    others = sorted(" ".join(name).strip() for name in fired if not matches(name, wanted))
    took = f"{when - site.began:.1f} s" if when else "not fired"
    is_met = bool(when) and not others and not site.failed
    told = [took, *(f"also {one}" for one in others), *([f"{site.failed!r}"] if site.failed else [])]
    common.row(what, f"{alert} {word}".strip(), ", ".join(told), is_met)


def matches(name, wanted):
    return name[0] == wanted[0] and wanted[1] in ("", name[1])


def provoked(site, provoke):
    try:
        provoke(site)
    except (Exception, SystemExit) as error:  # noqa: BLE001
        site.failed = error


def wait_for(site, wanted):
    """The moment at which the alert was seen to fire; none where it did not."""
    end = time.monotonic() + LATEST / site.prometheus.factor + SLACK
    while time.monotonic() < end and not site.failed:
        if site.observed:
            found = [when for name, when in site.prometheus.fired(site.observed.page).items() if matches(name, wanted)]
            if found:
                return min(found)
        time.sleep(0.1)
    return None


class Load:
    """Clients that do what clients do: sessions made and deleted, steps watched, cancelled, cut and gone on with, left
    to expire; meshes sent again and again, states exported and saved."""

    def __init__(self, site):
        self.site, self.counts, self.lock = site, {}, threading.Lock()

    def count(self, what):
        with self.lock:
            self.counts[what] = self.counts.get(what, 0) + 1

    def run(self, seconds, clients=4):
        threads = [threading.Thread(target=self.client, args=(seed,), daemon=True) for seed in range(clients)]
        for thread in threads:
            thread.start()
        time.sleep(seconds)
        self.site.over.set()
        for thread in threads:
            thread.join(30)

    def client(self, seed):
        dice = random.Random(seed)
        while not self.site.over.is_set():
            client = self.site.client()
            try:
                self.session(client, dice)
            except grpc.RpcError as error:
                self.count(f"refused: {error.details()}")
            client.close()
            self.site.over.wait(dice.uniform(0.1, 1.0))

    def session(self, client, dice):
        block = Block(dice.choice([1, 2, 4, 6]))
        client.upload(block)
        name = client.create(block.scene(rubber=dice.random() < 0.5))
        self.count("sessions")
        stream, depth = attached(client, name), 0.0
        for number in range(1, dice.randint(2, 6)):
            depth += dice.uniform(0.002, 0.01)
            act = dice.choice(["solve", "solve", "solve", "cancel", "cut", "look"])
            self.count(act)
            stream.step(number, depth, 2000 if act == "cancel" else dice.randint(1, 5))
            if act == "cancel":
                self.site.over.wait(dice.uniform(0.0, 1.0))
                client.sessions.CancelStep(session_pb.CancelStepRequest(name=name, sequence=number))
            if act == "cut":
                # The results so far come again.
                stream.call.cancel()
                stream = attached(client, name, last_seen_event=0)
                if client.describe(name).last_accepted_sequence < number:
                    stream.step(number, depth, 1)
            for finished, _ in stream.results():
                if finished.last and finished.sequence == number:
                    break
            if act == "look":
                self.look(client, name)
        stream.close()
        if dice.random() < 0.8:
            client.delete(name)

    def look(self, client, name):
        list(client.sessions.ExportState(session_pb.ExportStateRequest(name=name)))
        client.sessions.SaveState(session_pb.SaveStateRequest(name=name))
        client.sessions.ListSessions(session_pb.ListSessionsRequest())


def calm(prometheus, minutes):
    """Ordinary load, during which no alert may fire."""
    site = trial.Site(prometheus, "calm")
    server = site.server(data=True, session_ttl_seconds=30)
    load = Load(site)
    load.run(60 * minutes)
    time.sleep(max(20 / prometheus.factor, 3.0))
    fired = sorted(" ".join(name).strip() for name in prometheus.fired(server.page))
    lived = server.lives()
    site.clear()
    done = ", ".join(f"{count} {what}" for what, count in sorted(load.counts.items()))
    common.row(f"{minutes} minutes of ordinary load", "no alert", f"{fired or 'none'}; {done}", lived and not fired)


def main():
    given = common.arguments(__doc__, factor=30.0, together=4, minutes=10.0, only="")
    prometheus = Prometheus(given.factor)
    chosen = [one for one in enumerate(trial.ALL) if given.only in " ".join(one[1][:3])]
    try:
        with ThreadPoolExecutor(given.together) as pool:
            list(pool.map(lambda one: drill(prometheus, *one), chosen))
        if given.minutes:
            calm(prometheus, given.minutes)
    finally:
        with contextlib.suppress(Exception):
            prometheus.stop()
    common.finish()


if __name__ == "__main__":
    main()
