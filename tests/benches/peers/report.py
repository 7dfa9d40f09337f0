"""What a peer reports of one run, as one JSON line: the columns of peers.csv."""
import json
import os
import resource
import sys
import time

COLUMNS = (
    "scene level solver unknowns seconds failure peak_memory_mb iterations runs seconds_assembly seconds_setup seconds_solve "
    "error_displacement_l2 error_displacement_h1 error_pressure_l2 value_strain_energy value_force value_tangential_force value_contact_pressure "
    "threads version processor"
).split()


class Clock:
    """Wall seconds of the phases assembly, setup and solve; what lies between them is not counted."""

    def __init__(self):
        self.seconds = {}

    def phase(self, name):
        clock = self

        class Phase:
            def __enter__(self):
                self.start = time.perf_counter()

            def __exit__(self, *_):
                spent = time.perf_counter() - self.start
                clock.seconds[name] = clock.seconds.get(name, 0.0) + spent

        return Phase()


def processor():
    with open("/proc/cpuinfo", encoding="ascii", errors="replace") as lines:
        names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "unknown"


def threads():
    """Threads that a peer may use: the cores, unless OMP_NUM_THREADS says otherwise."""
    return int(os.environ.get("OMP_NUM_THREADS", len(os.sched_getaffinity(0))))


def emit(scene, level, solver, unknowns, clock, used, version, **rest):
    """Prints the row; peak memory is that of this process so far, error norms not yet taken."""
    row = {
        "scene": scene,
        "level": level,
        "solver": solver,
        "unknowns": int(unknowns),
        "seconds": sum(clock.seconds.values()),
        "threads": used,
        "version": version,
        "processor": processor(),
    }
    for phase, seconds in clock.seconds.items():
        row[f"seconds_{phase}"] = seconds
    row.update(rest)
    unknown = set(row) - set(COLUMNS)
    assert not unknown, unknown
    json.dump(row, sys.stdout)
    print(flush=True)


def peak_memory_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024e-6
