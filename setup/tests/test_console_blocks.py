"""Runs the console blocks of README.md and docs/how-to as they stand, and compares what they print.

A block that a comment `<!-- not run: reason -->` precedes is left out. A line `...` stands for any lines. Times and speeds are not
compared; stdout and stderr are taken together, as a terminal shows them. The command is `HOVERLOCK`, or the debug build of this workspace.
"""

import functools
import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs/how-to").glob("*.md"))]
BLOCK = re.compile(r"(?P<comment><!-- not run: [^>]+ -->\n)?```console\n(?P<text>.*?)```", re.DOTALL)
# A number with a unit of time or speed.
MEASURED = re.compile(r"\d+(\.\d+)?(?= (million cycles a second|ms|s|MiB)\b)")
# Notes of work that a later run does not repeat, and progress that a faster machine does not print: no part of a document.
NOTE = re.compile(r"hoverlock: (building|compiling|making|\d+ of \d+ \w+|\d+ flights;)")
# As the crate `hoverlock-cache` decides it.
CACHE = Path(os.environ.get("HOVERLOCK_CACHE") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hoverlock")
PICTURES = CACHE.resolve() / "pictures"
TARGET = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target")
COMMAND = Path(os.environ.get("HOVERLOCK") or TARGET / "debug/hoverlock")


def blocks():
    for document in DOCUMENTS:
        text = document.read_text()
        for match in BLOCK.finditer(text):
            if not match["comment"]:
                line = text.count("\n", 0, match.start("text")) + 1
                # The blocks of a document use the files of those above them: one worker runs them in order.
                marks = pytest.mark.xdist_group(document.name)
                yield pytest.param(match["text"], id=f"{document.relative_to(ROOT)}:{line}", marks=marks)


def matches(expected: list[str], printed: list[str]) -> bool:
    """Compares lines; `...` stands for any lines."""
    pattern = "".join(r"(?:.*\n)*?" if line == "..." else re.escape(line.rstrip()) + "\n" for line in expected)
    return re.fullmatch(pattern, "".join(f"{line.rstrip()}\n" for line in printed)) is not None


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """A folder with what the blocks find in a checkout after `make demo`: the pictures, the Verilog and an `out`."""
    if not (PICTURES / "aero1.jpg").is_file():
        pytest.skip(f"no pictures in {PICTURES}: run `make demo` once")
    if not COMMAND.is_file():
        pytest.skip(f"no {COMMAND}: run `cargo build --package hoverlock-cli`, or set HOVERLOCK")
    folder = tmp_path_factory.mktemp("checkout")
    (folder / "out").mkdir()
    (folder / "out/pictures").symlink_to(PICTURES)
    (folder / "rtl").symlink_to(ROOT / "rtl")
    return folder


@pytest.fixture(scope="session")
def printed(folder):
    """Runs a command line once, however many documents show it, and returns what it prints."""
    environment = os.environ | {"PATH": f"{COMMAND.parent}:{os.environ['PATH']}", "NO_COLOR": "1"}

    @functools.cache
    def run(line: str) -> str:
        done = subprocess.run(["bash", "-c", line], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True)
        assert done.returncode in (0, 1), done.stdout
        return "".join(text for text in done.stdout.splitlines(keepends=True) if not NOTE.match(text))

    return run


@pytest.mark.parametrize("block", list(blocks()))
def test_a_console_block_prints_what_the_document_shows(block, printed):
    for command in block.removeprefix("$ ").split("\n$ "):
        line, _, shown = command.partition("\n")
        actual = printed(line)
        assert matches(*(MEASURED.sub("#", text).splitlines() for text in (shown, actual))), (
            f"{line}\nthe document shows\n{shown}\nand the command prints\n{actual}")


def test_the_pattern_of_lines():
    assert matches(["a", "...", "c"], ["a", "b", "b", "c"])
    assert matches(["a", "..."], ["a"])
    assert not matches(["a", "c"], ["a", "b", "c"])
    assert not matches(["...", "c"], ["a"])
