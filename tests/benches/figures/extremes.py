#!/usr/bin/env python3
"""The study of stiff and extreme cases: its seconds, and how many of its rows are as they must be, fail, or are wrong."""
import re
import subprocess
import time

import common
from common import FOLDER, row


def main():
    given = common.arguments(__doc__)
    out = FOLDER / "extremes"
    command = [given.signorini, "bench", "--study", "extremes", "--out", str(out), *(["--quick"] if given.quick else [])]
    start = time.perf_counter()
    ended = subprocess.run(command, capture_output=True, text=True)
    seconds = time.perf_counter() - start
    row("the page, by one command", "<= 600 s", f"{seconds:.0f} s, exit code {ended.returncode}", ended.returncode == 0 and seconds <= 600)
    pages = "".join(p.read_text(errors="replace") for p in out.rglob("*.html"))
    found = re.search(r"\d+ rows: [^.<]*", pages)
    row("its rows", "none wrong", found.group() if found else "no such sentence", bool(found) and " 0 wrong" in found.group())
    common.finish()


main()
