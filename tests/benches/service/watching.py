"""A real Prometheus on loopback that watches servers with the shipped rules, and what it says of them.

So that a drill takes minutes, every time of the rules is divided by a factor: windows of rates, how long a thing has to
last (`for`), and how often Prometheus looks, one second at least. Thresholds stay as they are. With the factor 1 the
rules are those of `deploy/prometheus`, word for word.
"""
import json
import re
import subprocess
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

from common import FOLDER, free_port

RULES = Path(__file__).resolve().parents[3] / "deploy" / "prometheus"
# Seconds between two looks, and between two evaluations of the rules, as shipped.
LOOK, EVALUATION = 5, 15
# How often alerts are asked for, s.
PAUSE = 0.2


def shortened(text, factor):
    """The text of rules with all its times divided."""

    def milliseconds(minutes):
        return f"{round(60_000 * int(minutes) / factor)}ms"

    text = re.sub(r"\[(\d+)m\]", lambda found: f"[{milliseconds(found[1])}]", text)
    text = re.sub(r"offset (\d+)m", lambda found: f"offset {milliseconds(found[1])}", text)
    text = re.sub(r"for: (\d+)m", lambda found: f"for: {milliseconds(found[1])}", text)
    return re.sub(r"(\d+) \* 60\b", lambda found: f"{60 * int(found[1]) / factor:g}", text)


def get(url):
    with urllib.request.urlopen(url, timeout=10) as answer:
        return answer.read().decode()


class Prometheus:
    """The process, the servers that it watches, and when each alert of each was first seen."""

    def __init__(self, factor):
        self.folder, self.factor = FOLDER / "prometheus", factor
        self.folder.mkdir()
        self.targets, self.lock, self.seen = [], threading.Lock(), {}
        self.write_targets()
        self.url = f"http://127.0.0.1:{free_port()}"
        command = ["prometheus", f"--config.file={self.settings()}", f"--storage.tsdb.path={self.folder}/data"]
        command += [f"--web.listen-address={self.url.removeprefix('http://')}"]
        with open(self.folder / "log", "w") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log)
        self.wait_until_ready()
        threading.Thread(target=self.look, daemon=True).start()

    def settings(self):
        """Writes rules and settings; the path of these."""
        for name in ("rules.yml", "alerts.yml"):
            text = (RULES / name).read_text()
            (self.folder / name).write_text(shortened(text, self.factor))
        look, evaluation = (max(1, round(seconds / self.factor)) for seconds in (LOOK, EVALUATION))
        targets = {"files": [str(self.folder / "targets.json")], "refresh_interval": "1s"}
        settings = {
            "global": {"scrape_interval": f"{look}s", "scrape_timeout": "1s", "evaluation_interval": f"{evaluation}s"},
            "rule_files": ["rules.yml", "alerts.yml"],
            "scrape_configs": [{"job_name": "signorini", "file_sd_configs": [targets]}],
        }
        path = self.folder / "prometheus.yml"
        # JSON is YAML.
        path.write_text(json.dumps(settings))
        return path

    def wait_until_ready(self):
        end = time.monotonic() + 30
        while time.monotonic() < end:
            try:
                return get(f"{self.url}/-/ready")
            except OSError:
                time.sleep(0.1)
        raise SystemExit(f"Prometheus does not start: {(self.folder / 'log').read_text()[-600:]}")

    def stop(self):
        self.process.terminate()
        self.process.wait(30)

    def add(self, target):
        with self.lock:
            self.targets.append(target)
        self.write_targets()

    def drop(self, target):
        with self.lock:
            self.targets.remove(target)
        self.write_targets()

    def write_targets(self):
        with self.lock:
            new = self.folder / "targets.new"
            new.write_text(json.dumps([{"targets": self.targets}]))
            # At once, so that it is never read in part.
            new.rename(self.folder / "targets.json")

    def ask(self, query):
        found = json.loads(get(f"{self.url}/api/v1/query?{urllib.parse.urlencode({'query': query})}"))
        return found["data"]["result"]

    def looked(self, target):
        """How often the target has answered of late."""
        found = self.ask(f'sum_over_time(up{{instance="{target}"}}[5m])')
        return int(found[0]["value"][1]) if found else 0

    def look(self):
        """Notes every alert that fires, and when that was first seen."""
        while self.process.poll() is None:
            try:
                firing = self.ask('ALERTS{alertstate="firing"}')
            except (OSError, ValueError):
                # It ends, or is busy.
                firing = []
            for alert in firing:
                labels = alert["metric"]
                name = (labels.get("instance"), labels["alertname"], word(labels))
                self.seen.setdefault(name, time.monotonic())
            time.sleep(PAUSE)

    def fired(self, target):
        """The alerts of a target, by name and word, with the moment of each."""
        return {name[1:]: when for name, when in list(self.seen.items()) if name[0] == target}


def word(labels):
    """What tells two alerts of one name apart."""
    return next((labels[key] for key in ("reason", "kind", "certificate", "cause") if key in labels), "")
