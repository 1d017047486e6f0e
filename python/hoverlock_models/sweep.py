"""The points of a campaign on a Dask cluster: ``python -m hoverlock_models.sweep --scheduler ADDRESS``.

``hoverlock sweep --dask ADDRESS`` starts this program. A line of standard input is a point, a line of standard output its
result, in the order in which the points are finished. Both are rows of CSV; a line that begins with ``#`` is a remark. The workers call
`hoverlock_models.cosim.fly_point`, so this package must be installed where they run. If a worker dies, Dask gives its
points to another.
"""

from __future__ import annotations

import argparse
import sys

from .cosim import fly_point

RETRIES = 5
"""Number of times that a point is flown again after its worker died or the point failed."""


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m hoverlock_models.sweep", description=__doc__.splitlines()[0])
    parser.add_argument("--scheduler", required=True, metavar="ADDRESS", help="tcp://host:port")
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
        if not client.scheduler_info()["workers"]:
            start = f"dask worker {arguments.scheduler}"
            print(f"# no workers at {arguments.scheduler} yet: the points wait; `{start}` starts one", flush=True)
        points = [line.rstrip("\n") for line in sys.stdin if line.strip()]
        flights = [client.submit(fly_point, point, pure=False, retries=RETRIES) for point in points]
        try:
            for flight in as_completed(flights):  # type: ignore[no-untyped-call]
                print(flight.result().rstrip("\n"), flush=True)
        except (RuntimeError, ValueError) as error:
            print(error, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
