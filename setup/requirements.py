#!/usr/bin/env python3
"""Renders `docs/requirements.toml` as `docs/requirements.md`, and walks it in both directions.

    setup/requirements.py render     writes the page (`make results`)
    setup/requirements.py check      fails where a requirement has no evidence, or evidence no requirement

Evidence is what can fail: a test or a claim. What the keys mean is at the top of the file.
"""

import argparse
import re
import subprocess
import sys
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import results

SOURCE = Path("docs/requirements.toml")
PAGE = Path("docs/requirements.md")
PROVED = Path("formal/RESULTS.md")
SOURCES = {"paper": "published with the algorithm", "design": "follows from a choice made here", "users": "asked of a tool"}
TEXTS = {"statement", "source", "equation", "page"}
LISTS = {"model", "hardware", "tests", "claims", "figures"}
RUST_TEST = re.compile(r"#\[test\]|\bproptest! ?\{")
PYTHON_TEST = re.compile(r"^(?:async )?def test_|^@\w+\.test\b", re.MULTILINE)
HARDWARE = re.compile(r"derive\([^)]*\bLogicBlock\b")


class Project:
    """What a requirement can name."""

    def __init__(self, root: Path = results.ROOT):
        self.root = root
        listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=root, stdout=subprocess.PIPE,
                                check=True, text=True).stdout
        self.files = sorted(name for name in listed.split("\0") if name and (root / name).is_file())
        self.claims = {match[1]: match[2] for match in re.finditer(r"^\| `(\w+)` \|(?:.*\|)? (\d+) of \d+ \|$", self.text(PROVED), re.MULTILINE)}
        self.figures = set(results.Results(root).entries)

    def text(self, name: Path | str) -> str:
        return (self.root / name).read_text()

    def has_tests(self, name: str) -> bool:
        if name.endswith(".rs"):
            return bool(RUST_TEST.search(self.text(name)))
        return Path(name).name.startswith("test_") and name.endswith(".py") and bool(PYTHON_TEST.search(self.text(name)))

    def has_test(self, name: str, test: str) -> bool:
        return bool(re.search(rf"\b(?:fn|def) {re.escape(test)}\(", self.text(name)))

    def tested(self) -> list[str]:
        """Returns the files that have tests."""
        return [name for name in self.files if self.has_tests(name)]

    def hardware(self) -> list[str]:
        """Returns the files that define modules of hardware."""
        return [name for name in self.files if name.startswith("rtl/src/") and HARDWARE.search(self.text(name))]

    def requirements(self) -> dict[str, dict]:
        return tomllib.loads(self.text(SOURCE))


def faults(name: str, requirement: dict, project: Project) -> list[str]:
    """Returns what is wrong with a requirement."""
    found = [f"{key}: no such key" for key in requirement if key not in TEXTS | LISTS]
    found += [f"{key} is missing" for key in ("statement", "source", "model", "page") if not requirement.get(key)]
    if requirement.get("source") not in SOURCES:
        found.append(f"source is not one of {', '.join(SOURCES)}")
    if not requirement.get("tests") and not requirement.get("claims"):
        found.append("no test and no claim")
    for path in requirement.get("model", []) + requirement.get("hardware", []):
        if not any(file == path or file.startswith(f"{path}/") for file in project.files):
            found.append(f"{path} does not exist")
    for entry in requirement.get("tests", []):
        path, _, test = entry.partition("::")
        if path not in project.files:
            found.append(f"{path} does not exist")
        elif not project.has_tests(path):
            found.append(f"{path} has no test")
        elif test and not project.has_test(path, test):
            found.append(f"{path} has no test {test}")
    found += [f"no claim {claim} in {PROVED}" for claim in requirement.get("claims", []) if claim not in project.claims]
    found += [f"no figure {figure} in {results.RESULTS}" for figure in requirement.get("figures", []) if figure not in project.figures]
    return [f"{SOURCE}: {name}: {fault}" for fault in found]


def unserved(requirements: dict[str, dict], project: Project) -> list[str]:
    """Returns the tests, claims and modules of hardware that serve no requirement."""
    named = {key: {entry for requirement in requirements.values() for entry in requirement.get(key, [])} for key in LISTS}
    whole = {entry.partition("::")[0] for entry in named["tests"]}
    found = [f"{name}: its tests serve no requirement" for name in project.tested() if name not in whole]
    found += [f"claim {name} serves no requirement" for name in project.claims if name not in named["claims"]]
    found += [f"{name}: its hardware serves no requirement" for name in project.hardware() if name not in named["hardware"]]
    return [f"{fault}; name it in {SOURCE}" for fault in found]


def link(path: str, word: str | None = None) -> str:
    return f"[{word or f'`{path}`'}](../{path})"


def row(name: str, requirement: dict, project: Project) -> str:
    """Returns the row of a requirement."""
    equation = f"<br>`{requirement['equation']}`" if "equation" in requirement else ""
    tests = [link(entry.partition("::")[0], f"`{entry}`") for entry in requirement.get("tests", [])]
    claims = [f"`{claim}` ({project.claims[claim]})" for claim in requirement.get("claims", [])]
    figures = [f"`{figure}`" for figure in requirement.get("figures", [])]
    cells = [
        f"[`{name}`](../{requirement['page']}), {requirement['source']}<br>{requirement['statement']}{equation}",
        "<br>".join(link(path) for path in requirement["model"] + requirement.get("hardware", [])),
        "<br>".join(tests),
        "<br>".join(claims + figures),
    ]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def page(requirements: dict[str, dict], project: Project) -> str:
    """Returns the text of the page."""
    return "\n".join([
        "<!-- Written by `make results` from requirements.toml. Do not edit. -->", "", "# Requirements and their evidence", "",
        "Each requirement with what implements it and what would fail without it. Sources: "
        + ", ".join(f"*{key}*, {text}" for key, text in SOURCES.items()) + ".",
        "A number behind a claim is that of the faults that its proof detects. Figures are keys of [results.json](results.json).",
        "`make test` fails if a requirement has no evidence, or if a file of tests, a claim or a file of hardware serves no requirement. A file of",
        "tests serves as a whole; the walk does not look at its tests one by one.", "",
        "| requirement | model and hardware | tests | claims and figures |", "|---|---|---|---|",
        *(row(name, requirement, project) for name, requirement in requirements.items())]) + "\n"


def check(root: Path = results.ROOT) -> list[str]:
    """Returns one line for each fault of the file and of its page."""
    project = Project(root)
    requirements = project.requirements()
    found = [fault for name, requirement in requirements.items() for fault in faults(name, requirement, project)]
    found += unserved(requirements, project)
    if not found and (not (root / PAGE).is_file() or project.text(PAGE) != page(requirements, project)):
        found.append(f"{PAGE} is not that of {SOURCE}; run `make results`")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("verb", choices=["render", "check"])
    verb = parser.parse_args().verb
    project = Project()
    if verb == "render":
        requirements = project.requirements()
        if found := [fault for name, requirement in requirements.items() for fault in faults(name, requirement, project)]:
            print("\n".join(found), file=sys.stderr)
            return 1
        results.write(project.root / PAGE, page(requirements, project))
        return 0
    found = check()
    print("\n".join(found), file=sys.stderr, end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
