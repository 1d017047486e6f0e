#!/usr/bin/env python3
"""Runs every Rust test of the workspace, several test binaries at a time, and reports the time of each.

`cargo test` runs one binary after the other, so a binary with a single long test leaves the other cores idle. Here cargo
builds the binaries and lists them, and each runs once, including ignored tests except those named by `--skip`. The output
of a binary is printed when it ends. Doc tests are run by cargo. The exit status is 1 if a test failed; failed binaries are
listed at the end.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CARGO = ["cargo", "test", "--workspace", "--locked"]
TIMES = Path("out/test-times.json")


def built():
    """Builds all test binaries and returns name, package folder and path of each."""
    build = subprocess.run([*CARGO, "--no-run", "--message-format=json-render-diagnostics"], stdout=subprocess.PIPE)
    if build.returncode:
        sys.exit(build.returncode)
    found = []
    for line in build.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message["profile"]["test"]:
            folder = Path(message["manifest_path"]).parent
            name = f"{folder.relative_to(Path.cwd())}/{message['target']['name']}"
            found.append((name, folder, message["executable"]))
    return found


def seconds_before():
    """Returns the wall time of each binary in the last run, s. The longest is started first."""
    try:
        return json.loads(TIMES.read_text())
    except (OSError, ValueError):
        return {}


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--skip", nargs="*", default=[], help="ignored tests that are not run")
    options.add_argument("--again", nargs="+", default=[], metavar=("VARIABLE=VALUE", "BINARY"),
                         help="run these binaries a second time with this variable set")
    options.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="number of binaries at a time")
    options = options.parse_args()
    arguments = ["--include-ignored", *(word for name in options.skip for word in ("--skip", name))]

    waiting = [(name, folder, path, {}) for name, folder, path in built()]
    if options.again:
        variable, *names = options.again
        named = [binary for binary in waiting if binary[0] in names]
        if len(named) != len(names):
            sys.exit(f"run_tests.py: --again: not all of {names} are test binaries")
        waiting += [(f"{name} with {variable}", folder, path, dict([variable.split("=", 1)]))
                    for name, folder, path, _ in named]
    before = seconds_before()
    waiting.sort(key=lambda binary: before.get(binary[0], 1e9))
    total, started = len(waiting), time.monotonic()
    running, times, failed = {}, {}, []
    while waiting or running:
        while waiting and len(running) < options.jobs:
            name, folder, path, variables = waiting.pop()
            output = tempfile.TemporaryFile()
            process = subprocess.Popen([path, *arguments], cwd=folder, env=os.environ | variables,
                                       stdout=output, stderr=subprocess.STDOUT)
            running[process.pid] = (process, name, output, time.monotonic())
        pid, status, usage = os.wait4(-1, 0)
        process, name, output, since = running.pop(pid)
        process.returncode = os.waitstatus_to_exitcode(status)
        times[name] = time.monotonic() - since
        cost = usage.ru_utime + usage.ru_stime
        output.seek(0)
        sys.stdout.write(output.read().decode(errors="replace"))
        print(f"[{len(times)} of {total}] {name}: {'ok' if not process.returncode else 'FAILED'}, "
              f"{times[name]:.0f} s, {cost:.0f} s of processor time", flush=True)
        if process.returncode:
            failed.append(name)
    print(f"{total} test binaries in {time.monotonic() - started:.0f} s", flush=True)
    if not failed:
        TIMES.parent.mkdir(exist_ok=True)
        TIMES.write_text(json.dumps(times, indent=1))
    if subprocess.run([*CARGO, "--doc"]).returncode:
        failed.append("doc tests")
    if failed:
        print(f"failed: {', '.join(failed)}")
        sys.exit(1)


if __name__ == "__main__":
    main()
