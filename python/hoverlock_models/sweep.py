"""The points of a campaign on a Dask cluster: ``python -m hoverlock_models.sweep --scheduler ADDRESS``.

``hoverlock sweep --dask ADDRESS`` starts this. A line of standard input is a point, a line of standard output its
result, in the order in which the results come. Both are rows of CSV that this program does not read: the workers give
each point to the command ``hoverlock sweep --point``, which must be installed where they run. A worker that dies loses
nothing; Dask gives its points to another.
"""

from __future__ import annotations

import argparse
import subprocess
import sys

RETRIES = 5
"""How often a point is flown again where its worker dies or the command fails."""


def fly(command: str, point: str) -> str:
    """The result of a point, on a worker."""
    ended = subprocess.run([command, "sweep", f"--point={point}"], capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        raise RuntimeError(f"{command} sweep --point={point!r}: {ended.stderr.strip() or 'failed without a word'}")
    return ended.stdout.rstrip("\n")


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m hoverlock_models.sweep", description=__doc__.splitlines()[0])
    parser.add_argument("--scheduler", required=True, metavar="ADDRESS", help="tcp://host:port")
    parser.add_argument("--command", default="hoverlock", help="what the workers run")
    arguments = parser.parse_args()
    try:
        from distributed import Client, as_completed
    except ImportError:
        print("the package `distributed` is not installed: pip install 'hoverlock-models[dask]'", file=sys.stderr)
        return 2
    try:
        client = Client(arguments.scheduler, timeout="10s")  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        print(f"no scheduler at {arguments.scheduler}: {error}", file=sys.stderr)
        return 2
    with client:
        points = [line.rstrip("\n") for line in sys.stdin if line.strip()]
        flights = [client.submit(fly, arguments.command, point, pure=False, retries=RETRIES) for point in points]
        try:
            for flight in as_completed(flights):  # type: ignore[no-untyped-call]
                print(flight.result(), flush=True)
        except RuntimeError as error:
            print(error, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
