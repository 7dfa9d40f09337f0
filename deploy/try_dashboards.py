#!/usr/bin/env python3
"""Runs every query of every panel against a real Prometheus that watches a real server
at work, and fails where one is empty.

    try_dashboards.py PROGRAM [--seconds 60] [--pictures DIR]

PROGRAM is `signorini`; `prometheus` is that of the path (Debian's is enough). The
dashboards of fleets and studies are left out unless PROGRAM has the feature `fleet` and
`nats-server` is there. Python's own library does but for --pictures, which needs
matplotlib and draws each panel from the numbers that Grafana would get. Everything
listens on loopback and ends with the script.
"""

import argparse
import contextlib
import itertools
import json
import math
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.parse
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
EXAMPLES = HERE.parent / "client" / "examples"
DASHBOARDS = sorted((HERE / "grafana" / "dashboards").glob("*.json"))
# A server alone has none of their metrics.
OF_FLEETS = {"fleet", "studies"}
# Seconds of a lease of the fleet.
LEASE = 1

# Small enough that meshes and prepared data have to make room for each other.
SETTINGS = """
solver_slots = 2
threads_per_slot = 1
maximum_sessions = 6
memory_budget_bytes = 46_000_000
data = "{folder}/data"
tls_certificate = "{folder}/certificates/server.pem"
tls_key = "{folder}/certificates/server.key"
"""

# Nothing can change the volume of a body that is held all around: fails in a moment.
FULL = """
name = "full"
mesh = "{mesh}"
kind = "plane-strain"
[material.body]
model = "linear-elastic"
shear_modulus = 1.0
poisson_ratio = 0.5
[[support]]
name = "walls"
on = ["x0", "x1", "y0"]
displacement = {{ x = 0.0, y = 0.0 }}
[[support]]
name = "lid"
on = "y1"
displacement = {{ x = 0.0, y = -0.1 }}
"""


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def get(url):
    with urllib.request.urlopen(url, timeout=30) as answer:
        return answer.read().decode()


def wait_for(url, seconds=30):
    end = time.time() + seconds
    while True:
        try:
            return get(url)
        except (urllib.error.URLError, ConnectionError) as error:
            if time.time() > end:
                raise SystemExit(f"{url}: {error}") from error
            time.sleep(0.1)


@contextlib.contextmanager
def running(command, log):
    """A process that ends with the block."""
    with open(log, "w") as lines:
        process = subprocess.Popen(command, stdout=lines, stderr=subprocess.STDOUT)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(timeout=40)
        except subprocess.TimeoutExpired:
            process.kill()


def start_server(program, folder, stack):
    """Starts the server, with a session that an earlier life of it has left; returns the addresses
    of service and metrics page and the name of the session."""
    service, page = free_port(), free_port()
    settings, url = folder / "server.toml", f"https://127.0.0.1:{service}"
    settings.write_text(SETTINGS.format(folder=folder))
    subprocess.run([program, "certs", "init", folder / "certificates"], check=True, capture_output=True)
    # Every command that is started here finds it.
    os.environ["SIGNORINI_CA"] = str(folder / "certificates" / "ca.pem")
    command = [program, "serve", "--config", settings, "--listen", f"127.0.0.1:{service}"]
    command += ["--metrics-listen", f"127.0.0.1:{page}"]
    with running(command, folder / "first.log"):
        wait_for(f"http://127.0.0.1:{page}/healthz")
        scene = EXAMPLES / "hertz-plane.toml"
        solve = [program, "solve", scene, "--detach", "--server", url]
        told = subprocess.run(solve, check=True, capture_output=True, text=True)
        name = told.stdout.split()[-1]
        subprocess.run([program, "watch", name, "--server", url], check=True, capture_output=True)
    stack.enter_context(running(command, folder / "server.log"))
    wait_for(f"http://127.0.0.1:{page}/healthz")
    return url, f"127.0.0.1:{page}", name


def knows_fleets(program):
    """Whether there is NATS, and the program asks it."""
    asked = subprocess.run([program, "worker"], capture_output=True, text=True)
    return shutil.which("nats-server") is not None and "--queue URL is missing" in asked.stderr


class FleetLoad:
    """Two servers that take a session from each other, and workers of a study."""

    def __init__(self, program, folder, stack):
        self.program, self.folder, self.stack = program, folder, stack
        self.stop, self.pages = threading.Event(), []
        port = free_port()
        self.url = f"nats://127.0.0.1:{port}"
        store = folder / "nats"
        command = ["nats-server", "-js", "-a", "127.0.0.1", "-p", str(port), "-sd", store]
        stack.enter_context(running(command, folder / "nats.log"))
        wait_for_port(port)
        self.servers = [self.server(number) for number in range(2)]
        for number in range(2):
            self.worker(number)

    def server(self, number):
        service, page = free_port(), free_port()
        settings = self.folder / f"fleet-{number}.toml"
        settings.write_text(
            f'data = "{self.folder}/data-{number}"\nfleet_nats = "{self.url}"\n'
            f'fleet_store = "{self.folder}/shared"\nfleet_lease_seconds = {LEASE}\n'
        )
        command = [self.program, "serve", "--config", settings, "--listen", f"127.0.0.1:{service}"]
        command += ["--metrics-listen", f"127.0.0.1:{page}"]
        process = self.stack.enter_context(running(command, self.folder / f"fleet-{number}.log"))
        wait_for(f"http://127.0.0.1:{page}/healthz")
        self.pages.append(f"127.0.0.1:{page}")
        return process, f"http://127.0.0.1:{service}"

    def worker(self, number):
        page = f"127.0.0.1:{free_port()}"
        command = [self.program, "worker", "--queue", self.url, "--threads", "1", "--metrics", page]
        self.stack.enter_context(running(command, self.folder / f"worker-{number}.log"))
        wait_for(f"http://{page}/livez")
        self.pages.append(page)

    def call(self, *arguments):
        command = [self.program, *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=120)

    def take_over(self):
        """One server sleeps beyond its lease, the other takes the session, by turns."""
        scene = EXAMPLES / "hertz-plane.toml"
        for holder, other in itertools.cycle([self.servers, self.servers[::-1]]):
            if self.stop.is_set():
                return
            told = self.call("solve", scene, "--detach", "--server", holder[1])
            if told.returncode != 0:
                continue
            name = told.stdout.split()[-1]
            time.sleep(1.5)
            holder[0].send_signal(signal.SIGSTOP)
            time.sleep(2 * LEASE)
            self.call("session", "show", name, "--server", other[1])
            holder[0].send_signal(signal.SIGCONT)
            # Until its steps are made again.
            time.sleep(2.0)
            self.call("session", "delete", name, "--server", other[1])

    def study(self):
        """Studies without an end."""
        study, out = EXAMPLES / "studies" / "hertz.toml", self.folder / "study.csv"
        while not self.stop.is_set():
            self.call("study", study, "--out", out, "--queue", self.url, "--quiet")

    def threads(self):
        return [threading.Thread(target=self.take_over), threading.Thread(target=self.study)]


def wait_for_port(port):
    end = time.time() + 30
    while time.time() < end:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1):
            return
        time.sleep(0.1)
    raise SystemExit(f"nobody listens on {port}")


def start_prometheus(pages, folder, stack):
    """Starts Prometheus with the shipped rules, looking every second."""
    config = (HERE / "prometheus" / "prometheus.yml").read_text()
    port = free_port()
    config = config.replace("15s", "2s").replace("5s", "1s")
    config = config.replace("127.0.0.1:9464", '", "'.join(pages)).replace("127.0.0.1:9090", f"127.0.0.1:{port}")
    for name in ["rules.yml", "alerts.yml"]:
        config = config.replace(f"- {name}", f"- {HERE / 'prometheus' / name}")
    (folder / "prometheus.yml").write_text(config)
    command = ["prometheus", f"--config.file={folder / 'prometheus.yml'}"]
    command += [f"--storage.tsdb.path={folder / 'data'}", f"--web.listen-address=127.0.0.1:{port}"]
    stack.enter_context(running(command, folder / "prometheus.log"))
    url = f"http://127.0.0.1:{port}"
    wait_for(f"{url}/-/ready")
    return url


class Load:
    """Clients that keep a server busy: scenes of every kind, one that fails, requests that
    are refused, steps that are cancelled, results that are watched."""

    def __init__(self, program, server, folder):
        self.program, self.server, self.folder = program, server, folder
        self.stop = threading.Event()
        self.done, self.lock = {}, threading.Lock()
        full = folder / "full.toml"
        full.write_text(FULL.format(mesh=EXAMPLES / "meshes" / "square_n16.msh"))
        self.full = full

    def call(self, *arguments, expect=0):
        command = [self.program, *map(str, arguments), "--server", self.server]
        run = subprocess.run(command, capture_output=True, text=True, timeout=120)
        with self.lock:
            key = (arguments[0], run.returncode)
            self.done[key] = self.done.get(key, 0) + 1
        # A busy server may refuse (6), and a cancelled step is not converged (3).
        if not self.stop.is_set() and run.returncode not in (expect, 3, 6):
            print(f"{' '.join(command)}: code {run.returncode}\n{run.stderr}", file=sys.stderr)
        return run

    def solve(self, names, more=()):
        for name in itertools.cycle(names):
            if self.stop.is_set():
                return
            self.call("solve", EXAMPLES / name, "--quiet", *more)

    def fail(self):
        while not self.stop.wait(2.0):
            self.call("solve", self.full, "--quiet", expect=3)
            self.call("session", "show", "sessions/nobody", expect=2)

    def cancel(self):
        """Long steps that are watched and cancelled."""
        scene = EXAMPLES / "mr-sphere.toml"
        while not self.stop.wait(1.0):
            detached = self.call("solve", scene, "--detach", "--set", "step.0.increments=400")
            if detached.returncode != 0:
                continue
            name = detached.stdout.split()[-1]
            watching = threading.Thread(target=self.call, args=("watch", name))
            watching.start()
            self.stop.wait(4.0)
            self.call("cancel", name)
            watching.join()
            self.call("session", "delete", name)

    def crowd(self):
        """More sessions at once than there may be."""
        while not self.stop.wait(6.0):
            scene = EXAMPLES / "cook.toml"
            all_at_once = [
                threading.Thread(target=self.call, args=("solve", scene, "--quiet"))
                for _ in range(8)
            ]
            for one in all_at_once:
                one.start()
            for one in all_at_once:
                one.join()

    def wake(self, name):
        """A session comes back from the data folder, and goes."""
        self.stop.wait(10.0)
        self.call("session", "show", name)
        # Until its steps are made again.
        self.stop.wait(3.0)
        self.call("session", "delete", name)

    def run(self, seconds, name, others):
        scenes = ["hertz-plane.toml", "mr-uniax.toml", "cook.toml", "cube-bend.toml"]
        out = ["--out", self.folder / "out"]
        threads = [
            threading.Thread(target=self.solve, args=(scenes,)),
            threading.Thread(target=self.solve, args=(["slide-block.toml", "hertz-plane.toml"], out)),
            threading.Thread(target=self.fail),
            threading.Thread(target=self.cancel),
            threading.Thread(target=self.crowd),
            threading.Thread(target=self.wake, args=(name,)),
            *(others.threads() if others else []),
        ]
        for thread in threads:
            thread.start()
        time.sleep(seconds)
        self.stop.set()
        if others:
            others.stop.set()
        for thread in threads:
            thread.join()


class Asked:
    """Queries as Grafana would send them for a range of time."""

    def __init__(self, url, start, end):
        self.url, self.start, self.end = url, start, end

    def expression(self, text):
        values = {
            "$__rate_interval": "8s",
            "$__range": f"{int(self.end - self.start)}s",
            "$job": ".*",
            "$instance": ".*",
        }
        for name, value in values.items():
            text = text.replace(name, value)
        left = re.search(r"\$\w+", text)
        if left:
            raise SystemExit(f"unknown variable {left.group()} in {text}")
        return text

    def api(self, path, **parameters):
        url = f"{self.url}/api/v1/{path}?{urllib.parse.urlencode(parameters)}"
        try:
            return json.loads(get(url))["data"]
        except urllib.error.HTTPError as error:
            raise SystemExit(f"{parameters}: {error.read().decode()}") from error

    def series(self, target):
        """Finite points by legend."""
        query = self.expression(target["expr"])
        if target["instant"]:
            found = self.api("query", query=query, time=self.end)["result"]
            points = [(one["metric"], [one["value"]]) for one in found]
        else:
            found = self.api("query_range", query=query, start=self.start, end=self.end, step=1)
            points = [(one["metric"], one["values"]) for one in found["result"]]
        return {
            legend(target, metric): finite for metric, values in points if (finite := numbers(values))
        }


def numbers(values):
    pairs = [(when, float(value)) for when, value in values]
    return [(when, value) for when, value in pairs if math.isfinite(value)]


def legend(target, metric):
    fill = lambda found: metric.get(found.group(1), "")
    return re.sub(r"\{\{(\w+)\}\}", fill, target["legendFormat"]) or str(metric)


def check(asked, dashboards):
    """Asks everything; returns the answers by dashboard and panel, and what was empty."""
    answers, empty = {}, []
    for path in dashboards:
        board = json.loads(path.read_text())
        panels = answers.setdefault(path.stem, (board, {}))[1]
        for panel in board["panels"]:
            found = {}
            for target in panel["targets"]:
                series = asked.series(target)
                if not series:
                    empty.append(f"{board['title']}: {panel['title']}: {target['expr']}")
                found.update(series)
            panels[panel["id"]] = found
            count = sum(map(len, found.values()))
            print(f"{board['title']:44} {panel['title']:44} {len(found):3} series {count:6} points")
    return answers, empty


def check_rules(asked):
    """Recorded rules that gave nothing, and alerts that could not be asked."""
    wrong = []
    for group in asked.api("rules")["groups"]:
        for rule in group["rules"]:
            if rule["health"] != "ok":
                wrong.append(f"rule {rule['name']}: {rule.get('lastError', rule['health'])}")
            elif rule["type"] == "recording":
                if not asked.api("query", query=rule["name"], time=asked.end)["result"]:
                    wrong.append(f"rule {rule['name']}: nothing recorded")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=60.0, help="how long the server works")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for a picture of each dashboard")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder, program = pathlib.Path(name), str(arguments.program.resolve())
        server, page, old = start_server(program, folder, stack)
        others = FleetLoad(program, folder, stack) if knows_fleets(program) else None
        dashboards = [one for one in DASHBOARDS if others or one.stem not in OF_FLEETS]
        if not others:
            print("left out: fleets and studies, which need the feature `fleet` and nats-server")
        asked_url = start_prometheus([page, *(others.pages if others else [])], folder, stack)
        start = time.time()
        load = Load(program, server, folder)
        load.run(arguments.seconds, old, others)
        # One more look after the last result, and the rules once more.
        time.sleep(4.0)
        asked = Asked(asked_url, start, time.time())
        answers, empty = check(asked, dashboards)
        empty += check_rules(asked)
        print("calls by command and exit code:", load.done)
        if arguments.pictures:
            import draw_dashboards

            draw_dashboards.draw(answers, arguments.pictures)
        for line in empty:
            print(f"EMPTY {line}", file=sys.stderr)
        if empty:
            print((folder / "server.log").read_text()[-3000:], file=sys.stderr)
            sys.exit(1)


if __name__ == "__main__":
    main()
