"""Random histories of kills, cancels, resumptions, exports, saves and restores, with a checker that keeps every event
that was ever read: byte for byte, its times included.

Each history is one session on one server that is killed beneath it. Asked: no event that was read changes, is missing or
comes twice; a client that comes back hears the end of an update that is cancelled within `--patience` seconds of the
server's readiness; no replay finds another result. `--seed` makes the choices of a history the same again; `--log`
goes on where an earlier run was stopped. Where one breaks a promise the server's log is kept beside that of the run. On
a busy machine solves are slow: `--silence` gives them longer.

    python histories.py --histories 2000 --log histories.log
"""
import random
import shutil
import threading
import time
import traceback

import grpc

import common
from common import Block, Client, Server, scene_pb, session_pb

GAP = scene_pb.FIELD_NAME_GAP
DIFFERS = "a replay gave other results"
BROKEN = ("changed", "missing", "twice", "replays")


class Broken(Exception):
    """A promise was."""


class Checker:
    """Every event that was ever read, and what broke."""

    def __init__(self):
        self.read, self.newest = {}, 0
        self.changed, self.missing, self.twice = [], [], []

    def take(self, finished, data, after):
        """An event of a stream that began after the event `after`; the event to come after it."""
        event, content = finished.event, finished.SerializeToString(deterministic=True) + data
        if event <= after:
            self.twice.append(event)
            print(f"event {event} of update {finished.sequence} after event {after}", flush=True)
        elif event > after + 1:
            self.missing.append(event)
        if self.read.setdefault(event, content) != content:
            self.changed.append(event)
        self.newest = max(self.newest, event)
        return event

    def again(self, finished, data):
        """An event that is read again on its own."""
        content = finished.SerializeToString(deterministic=True) + data
        if self.read.setdefault(finished.event, content) != content:
            self.changed.append(finished.event)


class History:
    """One session, and a client that does what the dice say."""

    def __init__(self, server, block, seed):
        self.server, self.random, self.checker = server, random.Random(seed), Checker()
        self.steps, self.finished, self.saves, self.kills, self.cancels = [], 0, [], 0, 0
        self.ends, self.stream, self.ready = [], None, time.monotonic()
        self.client = Client(server.address)
        self.client.upload(block)
        scene = block.scene(rubber=seed % 3 == 0)
        scene.output.fields.append(GAP)
        self.name = self.client.create(scene)

    def run(self, acts):
        self.attach()
        for _ in range(acts):
            often = [self.send, self.some, self.kill] * 3
            self.random.choice([*often, self.cancel, self.cut, self.export, self.save, self.restore, self.back])()
        self.cancel()
        self.all()
        self.back()
        self.watched()
        self.client.delete(self.name)
        self.client.close()

    def attach(self):
        """Comes back after the newest event that was read, and sends what was not accepted."""
        self.stream, opened = attached(self.client, self.name, last_seen_event=self.checker.newest, fields=[GAP])
        self.stream.answers = self.stream.results()
        self.cursor = self.checker.newest
        if opened.last_event < self.checker.newest:
            self.checker.missing.append(self.checker.newest)
        for number in range(opened.session.last_accepted_sequence + 1, len(self.steps) + 1):
            self.stream.step(number, *self.steps[number - 1])

    def send(self):
        if len(self.steps) - self.finished < 3:
            self.steps.append((self.random.uniform(0.005, 0.05), self.random.choice([1, 3, 10, 30])))
            self.stream.step(len(self.steps), *self.steps[-1])

    def some(self):
        """Reads a few results."""
        for _ in range(self.random.randint(1, 12)):
            if self.finished == len(self.steps):
                return
            self.next()

    def all(self):
        while self.finished < len(self.steps):
            self.next()

    def next(self):
        watchdog = threading.Timer(common.given.silence, self.stream.call.cancel)
        watchdog.start()
        try:
            finished, data = next(self.stream.answers)
        except grpc.RpcError as error:
            raise Broken(f"no answer: {error.code()}, {error.details()}") from error
        finally:
            watchdog.cancel()
        self.cursor = self.checker.take(finished, data, self.cursor)
        if finished.last:
            self.finished = finished.sequence
        return finished

    def kill(self):
        """Kills the server, perhaps a moment later; the client comes back, perhaps cancelling first."""
        if self.random.random() < 0.3:
            time.sleep(self.random.uniform(0, 0.05))
        self.server.kill()
        self.kills += 1
        self.client.close()
        self.server.start()
        self.ready = time.monotonic()
        self.client = Client(self.server.address)
        waits = self.finished < self.accepted()
        is_first = self.random.random() < 0.3
        cancelled = self.cancel() if is_first and waits else 0
        self.attach()
        if not cancelled and waits and self.random.random() < 0.5:
            cancelled = self.cancel()
        if cancelled:
            self.hear(cancelled)

    def accepted(self):
        return self.client.describe(self.name).last_accepted_sequence

    def hear(self, sequence):
        """Reads up to the end of a cancelled update, and notes how long after readiness it came."""
        if sequence <= self.finished:
            self.checker.twice.append(-sequence)
            print(f"update {sequence} was cancelled, whose end was read: {self.finished} updates were", flush=True)
            return
        while self.finished < sequence:
            self.next()
        self.ends.append(time.monotonic() - self.ready)

    def cancel(self):
        """Cancels what runs, or a certain update; the sequence that the server names."""
        wanted = self.random.choice([0, self.finished + 1])
        request = session_pb.CancelStepRequest(name=self.name, sequence=wanted)
        self.cancels += 1
        return self.client.sessions.CancelStep(request, timeout=common.given.silence).sequence

    def cut(self):
        """Leaves without a word and comes back on a new connection."""
        self.stream.call.cancel()
        self.client.close()
        self.client = Client(self.server.address)
        self.attach()

    def export(self):
        request = session_pb.ExportStateRequest(name=self.name)
        for _ in self.client.sessions.ExportState(request, timeout=common.given.silence):
            pass

    def save(self):
        request = session_pb.SaveStateRequest(name=self.name)
        self.saves.append(self.client.sessions.SaveState(request, timeout=common.given.silence).save)

    def restore(self):
        if self.saves:
            number = self.random.choice(self.saves[-8:])
            request = session_pb.RestoreStateRequest(name=self.name, save=number)
            self.client.sessions.RestoreState(request, timeout=common.given.silence)

    def back(self):
        """Reads finished updates again."""
        for number in self.random.sample(range(1, self.finished + 1), min(3, self.finished)):
            request = session_pb.ReadStepRequest(name=self.name, sequence=number, fields=[GAP])
            finished, data = None, b""
            try:
                answers = list(self.client.sessions.ReadStep(request, timeout=common.given.silence))
            except grpc.RpcError as error:
                if error.code() is not grpc.StatusCode.NOT_FOUND:
                    raise
                self.checker.missing.append(-number)
                continue
            for answer in answers:
                if answer.WhichOneof("message") == "step_finished":
                    if finished is not None:
                        self.checker.again(finished, data)
                    finished, data = answer.step_finished, b""
                else:
                    data += answer.field.data
            if finished is not None:
                self.checker.again(finished, data)

    def watched(self):
        """Reads everything again from the beginning, on another stream."""
        idle = session_pb.WATCH_END_IDLE
        request = session_pb.WatchRequest(name=self.name, last_seen_event=0, fields=[GAP], until=idle)
        finished, data, cursor = None, b"", 0
        for answer in self.client.sessions.Watch(request, timeout=common.given.silence):
            kind = answer.WhichOneof("message")
            if kind == "step_finished":
                if finished is not None:
                    cursor = self.checker.take(finished, data, cursor)
                finished, data = answer.step_finished, b""
            elif kind == "field":
                data += answer.field.data
        if finished is not None:
            cursor = self.checker.take(finished, data, cursor)
        if cursor < self.checker.newest:
            self.checker.missing.append(self.checker.newest)

    def outcome(self, seed, replays):
        checker = self.checker
        counts = {"changed": len(checker.changed), "missing": len(checker.missing), "twice": len(checker.twice)}
        more = {"events": len(checker.read), "kills": self.kills, "cancels": self.cancels, "ends": self.ends}
        return {"seed": seed, **counts, "replays": replays, **more}


def attached(client, name, **more):
    """A stream on a session that the server perhaps still holds for the last one, and its opening."""
    while True:
        stream = client.solve(name, **more)
        try:
            return stream, next(stream.call).opened
        except grpc.RpcError as error:
            if "SESSION_BUSY" not in str(error.trailing_metadata()) and error.code() is not grpc.StatusCode.ABORTED:
                raise
            time.sleep(0.01)


def of_seed(server, block, seed, acts):
    """What came of one history; tells what broke, and keeps what the server said then."""
    history = History(server, block, seed)
    try:
        history.run(acts)
    except (Broken, grpc.RpcError):
        traceback.print_exc()
        history.checker.missing.append(0)
    log = server.folder / "log"
    outcome = history.outcome(seed, log.read_text().count(DIFFERS))
    if any(outcome[key] for key in BROKEN):
        print(f"history {seed}: {outcome}", flush=True)
        shutil.copy(log, f"{common.given.log or 'history'}.{seed}.txt")
    log.write_text("")
    return outcome


def main():
    given = common.arguments(__doc__, histories=100, acts=40, seed=1, patience=2.0, cells=3, silence=15.0)
    block, done = Block(given.cells), common.logged("history")
    known = {one["seed"] for one in done}
    server = Server(data=True, name="histories", maximum_in_flight=16)
    for seed in range(given.seed, given.seed + given.histories):
        if seed in known:
            continue
        done.append(of_seed(server, block, seed, given.acts))
        common.log("history", **done[-1])
    total = {key: sum(one[key] for one in done) for key in ("events", "kills", "cancels", *BROKEN)}
    what = f"{len(done)} histories, {total['kills']} kills, {total['cancels']} cancels, {total['events']} events"
    for key in BROKEN:
        common.row(f"{what}: {key}", "0", total[key], total[key] == 0)
    ends = [end for one in done for end in one["ends"]]
    worst = max(ends, default=0.0)
    common.row("end of a cancelled update after readiness", f"<= {given.patience} s", common.milliseconds(ends), worst <= given.patience)
    server.kill()
    common.finish()


if __name__ == "__main__":
    main()
