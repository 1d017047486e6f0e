"""Runs the command line in a child process, so that a run that ends without its results is a failed run: the bench called
``os._exit``, was killed, or brought the process down.

>>> status = supervise(main)
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .runner import Result

__all__ = ["Reporter", "supervise"]

# Seconds after which the parent looks whether the child has ended, although another process holds its pipe open.
_LOOK_AGAIN_S = 0.5
# Seconds that a child has to end after it has reported its status. A thread that the bench has left behind would hold it for
# any time.
_END_S = 5.0


class Reporter:
    """The child's end of the pipe: tells the parent what runs, and each result."""

    def __init__(self, pipe: int | None) -> None:
        self.pipe = pipe
        self.process = os.getpid()

    def results_go_to(self, path: str, errors_are_failures: bool) -> None:
        """Reports the file of the results, and their style."""
        self._send(path=os.path.abspath(path), errors_are_failures=errors_are_failures)

    def test(self, module: str, name: str, result: Result | None) -> None:
        """Reports the begin or the end of a test; without a module, that all tests begin again."""
        if not module:
            self._send(again=True)
        elif result is None:
            self._send(module=module, name=name)
        else:
            error = None if result.error is None else type(result.error).__name__
            done = [result.name, result.module, result.seed, result.seconds, result.skipped, error, result.text]
            self._send(done=done)

    def end(self, status: int) -> None:
        """Reports the exit status of a run that has come to its end."""
        self._send(status=status)

    def _send(self, **message: Any) -> None:
        if os.getpid() != self.process:
            os._exit(1)  # a bench called os.fork, and its child went on: it must not give the verdict, nor write the results
        if self.pipe is not None:
            os.write(self.pipe, (json.dumps(message) + "\n").encode())


def supervise(main: Callable[[Reporter], int]) -> int:
    """Calls ``main`` in a child process and returns its exit status, or 1 if the child ended early. Then the results that
    the child has reported are written, with an error for the test that ran."""
    read, write = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(read)
        reporter = Reporter(write)
        status = main(reporter)
        sys.stdout.flush()
        reporter.end(status)
        return status
    os.close(write)
    # Ctrl-C reaches the child too, which ends by itself.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: os.kill(child, signal.SIGTERM))
    text, waited = _messages(read, child)
    messages = [json.loads(line) for line in text.decode().splitlines() if line.endswith("}")]
    status = waited if waited is not None else os.waitpid(child, 0)[1]
    ended = [message["status"] for message in messages if "status" in message]
    if ended and not os.WIFSIGNALED(status):
        return int(ended[0])
    how = f"was ended by signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else f"ended with status {os.WEXITSTATUS(status)}"
    return _write_what_is_known(messages, f"the process {how} before the run was over")


def _messages(pipe: int, child: int) -> tuple[bytes, int | None]:
    """Reads to the end of the pipe or of the child. The second value is the child's status if it was waited for; a child that
    does not end after it has reported its status is killed."""
    text = b""
    limit: float | None = None
    while True:
        if limit is None and b'"status"' in text:
            limit = time.monotonic() + _END_S
        ready, _, _ = select.select([pipe], [], [], _LOOK_AGAIN_S)
        if ready:
            more = os.read(pipe, 1 << 16)
            text += more
            if not more:
                return text, None
            continue
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return text, status
        if limit is not None and time.monotonic() > limit:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return text, 0


def _write_what_is_known(messages: list[dict[str, Any]], text: str) -> int:
    from .errors import HoverlockError
    from .runner import Result, write_junit

    path, errors_are_failures = None, False
    results: list[Result] = []
    begun = ("", "")
    for message in messages:
        if "path" in message:
            path, errors_are_failures = message["path"], message["errors_are_failures"]
        elif "again" in message:
            results = []
        elif "done" in message:
            name, module, seed, seconds, skipped, error, report = message["done"]
            failure = None if error is None else HoverlockError(report.strip().rpartition("\n")[2] or error)
            results.append(Result(name, module, seed, seconds, error is None and skipped is None, skipped, failure, report))
            begun = ("hoverlock", "run")
        elif "module" in message:
            begun = (message["module"], message["name"])
    module, name = begun
    results.append(Result(name or module or "run", module, 0, 0.0, False, None, HoverlockError(text), text))
    print(f"FAIL {module}.{name}: {text}" if name else f"FAIL {module}: {text}", flush=True)
    if path is not None:
        try:
            write_junit(results, path, errors_are_failures=errors_are_failures)
        except OSError as error:
            print(f"hoverlock: the results cannot be written: {error}", file=sys.stderr)
    return 1
