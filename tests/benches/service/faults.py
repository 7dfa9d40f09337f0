"""Faults of a running server, each with the alert that has to fire for it, and none beside."""
import contextlib
import resource
import shutil
import socket
import ssl
import subprocess
import time

import grpc

import common
from common import FOLDER, Block, attached, session_pb
from trial import LeftOut, ask, fault, fill, frozen, small_disk, until_the_last


@fault("the server is stopped", "SignoriniDown")
def stopped(site):
    server = site.server()
    site.begin()
    server.kill()
    site.over.wait()


@fault("a solver thread hangs", "SignoriniNoProgress")
def hung(site):
    server = site.server(solver_slots=1, threads_per_slot=1)
    site.works(Block(4))
    site.begin()
    with frozen(server):
        site.over.wait()


@fault("a cancelled step does not stop", "SignoriniStepLeftBehind")
def left_behind(site):
    server = site.server(solver_slots=1, threads_per_slot=1)
    client, name = site.works(Block(4))
    site.begin()
    with frozen(server):
        client.sessions.CancelStep(session_pb.CancelStepRequest(name=name))
        while server.sample("signorini_steps_left_behind_total") == 0 and not site.over.is_set():
            time.sleep(0.1)
    site.over.wait()


@fault("the data folder is moved away", "SignoriniDataFolderGone")
def folder_gone(site):
    server = site.server(data=True)
    client, _, _ = site.pressed()
    site.begin()
    (server.folder / "data").rename(server.folder / "away")
    scene = Block(1).scene()
    site.repeat(lambda: client.create(scene))
    (server.folder / "away").rename(server.folder / "data")


@fault("the disk of the data folder is full", "SignoriniDataUnwritable")
def disk_full(site):
    with small_disk(site) as place:
        server = site.server(data=str(place / "data"))
        client, _, _ = site.pressed()
        site.begin()
        fill(place, 0)
        scene = Block(1).scene()
        # The journal has some pages left.
        request = session_pb.CreateSessionRequest(scene=scene)
        end = time.monotonic() + 30
        while ask(client, "CreateSession", request) != grpc.StatusCode.UNAVAILABLE:
            if time.monotonic() > end:
                raise AssertionError("the disk is full, and sessions are taken")
        if server.ready() != 503:
            raise AssertionError("nothing can be written, and /healthz says that it is ready")
        site.repeat(lambda: client.create(scene))
        (place / "filler").unlink()
        end = time.monotonic() + 10
        while server.ready() != 200:
            if time.monotonic() > end:
                raise AssertionError("there is room again, and /healthz does not say so within 10 s")
            time.sleep(0.1)
        server.kill()


@fault("the disk of the data folder is nearly full", "SignoriniDiskNearlyFull")
def disk_nearly_full(site):
    with small_disk(site) as place:
        server = site.server(data=str(place / "data"))
        site.pressed()
        site.begin()
        fill(place, 4 << 20)
        site.over.wait()
        server.kill()


@fault("more work than the slots do", "SignoriniQueue")
def queue(site):
    site.server(solver_slots=1, threads_per_slot=1)
    site.begin()
    for _ in range(40):
        site.works(Block(9))
    site.over.wait()


@fault("the queue is full", "SignoriniOverload", "QUEUE_FULL")
def queue_full(site):
    site.server(solver_slots=1, threads_per_slot=1, maximum_queued=1)
    site.begin()
    site.works(Block(4))
    site.repeat(lambda: site.works(Block(4)))


@fault("too many sessions", "SignoriniOverload", "SESSION_LIMIT")
def session_limit(site):
    site.server(maximum_sessions=1)
    client, _ = site.session(Block(1))
    site.begin()
    site.repeat(lambda: client.create(Block(1).scene()))


@fault("a scene that is too large", "SignoriniOverload", "MEMORY_BUDGET")
def too_large(site):
    site.server(memory_budget_bytes=60_000_000)
    client, block = site.client(), Block(16)
    site.begin()
    site.repeat(lambda: client.upload(block) and client.create(block.scene()))


@fault("a client calls too often", "SignoriniOverload", "CALL_RATE")
def call_rate(site):
    site.server(maximum_client_calls_per_second=5)
    client = site.client()
    site.begin()
    request = session_pb.ListSessionsRequest()
    site.repeat(lambda: [ask(client, "ListSessions", request) for _ in range(20)])


@fault("sessions hold the memory budget", "SignoriniMemoryBudget")
def memory_held(site):
    server = site.server(memory_budget_bytes=100_000_000)
    client, block = site.client(), Block(4)
    client.upload(block)
    site.begin()
    while server.sample('signorini_memory_bytes{kind="session"}') < 81_000_000:
        client.create(block.scene(rubber=True))
    site.over.wait()


@fault("the process holds more than its budget", "SignoriniMemoryBeyondBudget")
def memory_beyond(site):
    if not shutil.which("cc"):
        raise LeftOut("a leak needs a C compiler")
    source, library, sign = (FOLDER / f"leak.{end}" for end in ("c", "so", "sign"))
    # Once the sign is there, 512 MiB are taken and touched.
    source.write_text(
        "#include <pthread.h>\n#include <stdlib.h>\n#include <string.h>\n#include <unistd.h>\n"
        "static void *leak(void *path) { while (access(path, F_OK)) usleep(100000);\n"
        "  size_t size = 512UL << 20; return memset(malloc(size), 1, size); }\n"
        f'__attribute__((constructor)) static void start(void) {{ pthread_t one; '
        f'pthread_create(&one, 0, leak, "{sign}"); }}\n'
    )
    subprocess.run(["cc", "-O0", "-shared", "-fPIC", "-pthread", "-o", library, source], check=True)
    site.server(memory_budget_bytes=100_000_000, prefix=["env", f"LD_PRELOAD={library}"])
    site.begin()
    sign.touch()
    site.over.wait()


# Nothing can change the volume of a body that is held all around.
HELD = """
name = "held"
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


@fault("scenes that do not converge", "SignoriniFailures")
def failures(site):
    server = site.server()
    scene, meshes = FOLDER / "held.toml", common.PROTO.parent / "client/examples/meshes"
    scene.write_text(HELD.format(mesh=meshes / "square_n16.msh"))
    command = [common.given.signorini, "solve", scene, "--quiet", "--server", server.address]
    site.begin()
    site.repeat(lambda: subprocess.run(command, capture_output=True))


@fault("the system has no memory for a step", "SignoriniInternalError")
def no_memory(site):
    server = site.server(solver_slots=1, threads_per_slot=1)
    client, name = site.session(Block(14))
    stream = attached(client, name)
    stream.step(1, 0.01)
    list(until_the_last(stream))
    site.begin()
    limit = server.memory("VmSize") + (4 << 20)
    resource.prlimit(server.process.pid, resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
    stream.step(2, 0.02)
    list(until_the_last(stream))
    resource.prlimit(server.process.pid, resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    site.over.wait()


@fault("a client sends faulty scenes", "SignoriniRefusals", "SCENE_INVALID")
def faulty(site):
    site.server()
    client, block = site.client(), Block(1)
    client.upload(block)
    site.begin()
    scene = block.scene(tolerance=-1.0)
    site.repeat(lambda: client.create(scene))


@fault("descriptors run out", "SignoriniDescriptors")
def descriptors(site):
    server = site.server()
    site.begin()
    open_now = server.sample("process_open_fds")
    limit = int(open_now * 1.1) + 1
    resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (limit, limit))
    site.over.wait()


@fault("one client has too many connections", "SignoriniConnectionsTurnedAway", "client")
def turned_away(site):
    server = site.server(maximum_client_connections=4)
    path = server.address.removeprefix("unix:")
    site.begin()

    def knock():
        with contextlib.ExitStack() as stack:
            for _ in range(8):
                one = stack.enter_context(socket.socket(socket.AF_UNIX))
                one.connect(path)
            time.sleep(0.2)

    site.repeat(knock)


def certified(site, days):
    """A server with transport security whose certificate is good for so long."""
    folder = FOLDER / f"certificates-{site.number}"
    command = [common.given.signorini, "certs", "init", folder, "--host", "localhost", "--days", str(days)]
    subprocess.run(command, check=True, capture_output=True)
    files = {"tls_certificate": str(folder / "server.pem"), "tls_key": str(folder / "server.key")}
    return site.server(loopback=True, **files)


@fault("clients do not trust the authority", "SignoriniHandshakes")
def handshakes(site):
    server = certified(site, 365)
    host, port = server.address.split(":")
    site.begin()

    def knock():
        # Nobody here knows that authority.
        context = ssl.create_default_context()
        with socket.create_connection((host, int(port)), 5) as one, contextlib.suppress(ssl.SSLError):
            context.wrap_socket(one, server_hostname="localhost")

    site.repeat(knock)


@fault("a certificate is good for ten days", "SignoriniCertificateEnds", "server")
def certificate_ends(site):
    site.began = time.monotonic()
    certified(site, 10)
    site.over.wait()


@fault("a certificate is good for a day", "SignoriniCertificateEndsNow", "server")
def certificate_ends_now(site):
    site.began = time.monotonic()
    certified(site, 1)
    site.over.wait()
