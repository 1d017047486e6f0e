#!/usr/bin/env python3
"""Keeps the measured numbers of the documents in one file, `docs/results.json`.

    setup/results.py render     writes the file's values into the documents (`make results`)
    setup/results.py check      fails where a document and the file differ (`make test`)
    setup/results.py record     stores measured values with today's date and the commit

An entry has a key, a `figure` (what was measured), a `unit`, the `conditions`, the `command` that measures it again, `date`, `commit`, and
either one `value` or named `values`: `rtl.estimate.kt27.alm` is the value `alm` of the entry `rtl.estimate.kt27`.

A document, which is any Markdown file in git, shows values in two ways:

    <!-- result rtl.estimate.kt27.alm -->9667<!-- /result -->
    <!-- table rtl_designs -->
    ... everything up to the closing mark is the rendered `docs/tables/rtl_designs.md` ...
    <!-- /table -->

In a template of `docs/tables`, `{{ rtl.estimate.kt27.alm }}` is the value. Both marks take an expression and a format:

    {{ bench.hoverlock / bench.cocotb : .0f }}      + - * / of keys and numbers, from left to right; a format of Python
    {{ bench.hoverlock : si }}                      three significant digits with k or M
    {{ bench @ date }}                              `date`, `commit`, `conditions`, `command` or `unit` of an entry
    {{ bench @ source }}                            date, commit and command in one phrase
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from datetime import date as calendar
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = Path("docs/results.json")
TABLES = Path("docs/tables")
FIELDS = ("figure", "unit", "conditions", "command", "date", "commit")
INLINE = re.compile(r"<!-- result (?P<expression>[^>]+?) -->(?P<text>.*?)<!-- /result -->")
TABLE = re.compile(r"<!-- table (?P<name>\w+) -->\n(?P<text>.*?)<!-- /table -->", re.DOTALL)
PLACEHOLDER = re.compile(r"\{\{ (.+?) \}\}")
MEND = "run `make results`"


class Mistake(Exception):
    """A mistake in a document, a template, the results file or an argument."""


class Results:
    """The entries of `docs/results.json`, and the keys that were looked up in them."""

    def __init__(self, root: Path = ROOT):
        self.root = root
        self.used: set[str] = set()
        try:
            self.entries = json.loads((root / RESULTS).read_text())
        except (OSError, ValueError) as error:
            raise Mistake(f"{RESULTS}: {error}") from error
        for key, entry in self.entries.items():
            if missing := [name for name in FIELDS if not entry.get(name)]:
                raise Mistake(f"{RESULTS}: {key} has no {missing[0]}")
            if ("value" in entry) == ("values" in entry):
                raise Mistake(f"{RESULTS}: {key} must have either `value` or `values`")

    def split(self, key: str) -> tuple[str, str | None]:
        """Returns the entry of a key and the name of the value in it, `None` for an entry with one value."""
        if key in self.entries:
            return key, None
        entry = key
        while "." in entry:
            entry = entry.rpartition(".")[0]
            if entry in self.entries:
                return entry, key[len(entry) + 1 :]
        raise Mistake(f"{RESULTS} has no {key}")

    def value(self, key: str):
        """Returns the value of a key."""
        entry, name = self.split(key)
        self.used.add(entry)
        if name is None:
            if "value" not in self.entries[entry]:
                raise Mistake(f"{entry} has several values: {', '.join(self.entries[entry]['values'])}")
            return self.entries[entry]["value"]
        try:
            return self.entries[entry]["values"][name]
        except KeyError:
            raise Mistake(f"{RESULTS}: {entry} has no value {name}") from None

    def field(self, key: str, name: str) -> str:
        """Returns a field of an entry, or `source`: when, at which commit and by which command it was measured."""
        if key not in self.entries:
            raise Mistake(f"{RESULTS} has no entry {key}")
        self.used.add(key)
        entry = self.entries[key]
        if name == "source":
            return f"{entry['date']}, commit {entry['commit']}, `{entry['command']}`"
        if name not in FIELDS:
            raise Mistake(f"`@ {name}`: not one of {', '.join(FIELDS)}, source")
        return entry[name]

    def expression(self, text: str) -> str:
        """Evaluates `KEY [OPERATOR KEY|NUMBER].. [: FORMAT]` or `ENTRY @ FIELD` and formats the result."""
        if " @ " in text:
            return self.field(*text.split(" @ ", 1))
        operands, _, form = text.partition(" : ")
        words = operands.split()
        total = self.operand(words[0])
        if len(words) % 2 == 0:
            raise Mistake(f"`{text}`: an operand is missing")
        for operator, word in zip(words[1::2], words[2::2]):
            right = self.operand(word)
            if operator not in OPERATORS:
                raise Mistake(f"`{text}`: the operator {operator} is not one of + - * /")
            total = OPERATORS[operator](total, right)
        return formatted(total, form.strip())

    def operand(self, word: str):
        """Returns the number that a word is, or the value of the key that it names."""
        try:
            return float(word) if "." in word else int(word)
        except ValueError:
            return self.value(word)

    def store(self) -> None:
        """Writes the file beside its goal and renames it, so that an interrupted run leaves the old one whole."""
        write(self.root / RESULTS, json.dumps(dict(sorted(self.entries.items())), indent=2, ensure_ascii=False) + "\n")


OPERATORS = {"+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b}


def formatted(value, form: str) -> str:
    """Formats a value: `si` with three significant digits and k or M, otherwise as Python does."""
    if form != "si":
        try:
            return format(value, form)
        except ValueError as error:
            raise Mistake(f"format `{form}` of {value!r}: {error}") from error
    unit = ""
    for limit, suffix in ((1e6, " M"), (1e3, " k")):
        if value >= 0.9995 * limit:
            value, unit = value / limit, suffix
            break
    digits = 2 if value < 9.995 else 1 if value < 99.95 else 0
    return f"{value:.{digits}f}{unit}"


def write(path: Path, text: str) -> None:
    """Writes a file under a temporary name in its folder and renames it."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8") as file:
        file.write(text)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def documents(root: Path) -> list[Path]:
    """Returns the Markdown files of the project, except for the templates."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "*.md"], cwd=root,
                            stdout=subprocess.PIPE, check=True, text=True).stdout
    paths = [Path(name) for name in listed.split("\0") if name]
    return sorted(path for path in paths if path.parent != TABLES and (root / path).is_file())


def template(root: Path, name: str) -> list[str]:
    """Returns the lines of a template."""
    try:
        return (root / TABLES / f"{name}.md").read_text().splitlines()
    except OSError as error:
        raise Mistake(f"no template {TABLES}/{name}.md") from error


def rendered_line(line: str, results: Results) -> str:
    return PLACEHOLDER.sub(lambda match: results.expression(match[1]), line)


def rendered(text: str, results: Results) -> str:
    """Returns the text of a document with the values of the file."""
    def table(match: re.Match) -> str:
        lines = [rendered_line(line, results) for line in template(results.root, match["name"])]
        return f"<!-- table {match['name']} -->\n" + "".join(f"{line}\n" for line in lines) + "<!-- /table -->"

    def inline(match: re.Match) -> str:
        return f"<!-- result {match['expression']} -->{results.expression(match['expression'])}<!-- /result -->"

    return INLINE.sub(inline, TABLE.sub(table, text))


def differences(path: Path, text: str, results: Results) -> list[str]:
    """Returns one line for each value of a document that differs from the file."""
    found = []

    def report(at: int, what: str) -> None:
        found.append(f"{path}:{text.count(chr(10), 0, at) + 1}: {what}; {MEND}")

    for match in INLINE.finditer(text):
        expected = results.expression(match["expression"])
        if match["text"] != expected:
            report(match.start(), f"{match['expression']} is {match['text']!r} here and {expected!r} in {RESULTS}")
    for match in TABLE.finditer(text):
        source = template(results.root, match["name"])
        lines = match["text"].splitlines()
        at = match.start("text")
        for line, form in zip(lines, source):
            if line != rendered_line(form, results):
                report(at, difference(line, form, results, match["name"]))
            at += len(line) + 1
        if len(lines) != len(source):
            report(at, f"table {match['name']} has {len(lines)} lines here and {len(source)} in its template")
    return found


def difference(line: str, form: str, results: Results, name: str) -> str:
    """Says in what a line of a table differs from its template: by a value, or by its text."""
    parts = PLACEHOLDER.split(form)
    pattern = "".join(re.escape(part) if index % 2 == 0 else "(.*?)" for index, part in enumerate(parts))
    if match := re.fullmatch(pattern, line):
        for expression, here in zip(parts[1::2], match.groups()):
            if here != (expected := results.expression(expression)):
                return f"{expression} is {here!r} here and {expected!r} in {RESULTS}"
    return f"table {name} reads {line!r} here and {rendered_line(form, results)!r} by its template"


def render(root: Path = ROOT) -> list[Path]:
    """Writes the values of the file into the documents and returns those that changed."""
    results, changed = Results(root), []
    for path in documents(root):
        text = (root / path).read_text()
        try:
            new = rendered(text, results)
        except Mistake as mistake:
            raise Mistake(f"{path}: {mistake}") from mistake
        if new != text:
            write(root / path, new)
            changed.append(path)
    return changed


def check(root: Path = ROOT) -> list[str]:
    """Returns one line for each difference between documents and file, and for each entry and template without a document."""
    results, found, tables = Results(root), [], set()
    for path in documents(root):
        text = (root / path).read_text()
        tables |= {match["name"] for match in TABLE.finditer(text)}
        opened = len(re.findall(r"<!-- (?:result|table) (?!KEY|NAME)", text))
        closed = len(INLINE.findall(text)) + len(TABLE.findall(text))
        if opened != closed:
            found.append(f"{path}: a mark of `result` or `table` is not closed")
        try:
            found += differences(path, text, results)
        except Mistake as mistake:
            found.append(f"{path}: {mistake}")
    found += [f"{RESULTS}: no document shows {key}; remove it or add it to a table" for key in results.entries
              if key not in results.used]
    found += [f"{path.relative_to(root)}: no document has this table" for path in sorted((root / TABLES).glob("*.md"))
              if path.stem not in tables]
    return found


def state(root: Path) -> str:
    """Returns the commit, with `-dirty` where files in git have changed since that a result may depend on."""
    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], cwd=root, stdout=subprocess.PIPE, text=True).stdout.strip()
    # A result that was recorded before this one changes no other.
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", f":!{RESULTS}", ":!*.md")
    commit = git("rev-parse", "HEAD")[:8]
    return commit + ("-dirty" if changed else "") if commit else "unknown"


def record(values: dict, root: Path = ROOT, **fields: str) -> None:
    """Stores values by key, with today's date and the commit, unless `fields` name others.

    A key that the file does not have becomes a new entry, and needs `figure`, `unit`, `conditions` and `command`. Other
    entries keep the fields that are not given. A dict of named values replaces all values of its entry.
    """
    results = Results(root)
    for key, value in values.items():
        try:
            key, name = results.split(key)
        except Mistake:
            name = None
            if missing := [field for field in FIELDS[:4] if not fields.get(field)]:
                raise Mistake(f"{key} is new: give its {missing[0]} (--{missing[0]})") from None
            results.entries[key] = {}
        entry = results.entries[key]
        if name is None and isinstance(value, dict):
            entry.pop("value", None)
            entry["values"] = value
        elif name is None and "values" in entry:
            raise Mistake(f"{key} has several values: {', '.join(entry['values'])}")
        elif name is None:
            entry["value"] = value
        elif "values" not in entry:
            raise Mistake(f"{key} has one value, and no {name}")
        else:
            entry["values"][name] = value
        entry |= {"date": calendar.today().isoformat(), "commit": state(root)}
        entry |= {field: text for field, text in fields.items() if text}
    results.store()


def commits(rows: list[dict]) -> str:
    """Returns the commits of the programs that flew the rows of a table, eight digits each."""
    short = lambda commit: commit[:8] + ("-dirty" if commit.endswith("-dirty") else "")
    return ", ".join(dict.fromkeys(short(row["commit"]) for row in rows))


def number(text: str):
    """Returns the number that a text is, or the text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def from_output(lines) -> dict:
    """Passes the output of a bench on to stdout, and returns the values of its lines `result KEY=VALUE`."""
    values = {}
    for line in lines:
        if line.startswith("result ") and "=" in line:
            key, _, value = line.removeprefix("result ").strip().partition("=")
            values[key] = number(value)
        else:
            print(line, end="", flush=True)
    return values


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    verbs = parser.add_subparsers(dest="verb", required=True)
    verbs.add_parser("render", help="write the values of the file into the documents")
    verbs.add_parser("check", help="status 1 where a document and the file differ")
    recording = verbs.add_parser("record", help="store values; from stdin, lines `result KEY=VALUE`, where none is given")
    recording.add_argument("values", nargs="*", metavar="KEY=VALUE")
    for field in FIELDS[:4]:
        recording.add_argument(f"--{field}")
    options = parser.parse_args()
    try:
        if options.verb == "record":
            if malformed := [text for text in options.values if "=" not in text]:
                raise Mistake(f"{malformed[0]} is not KEY=VALUE")
            values = {key: number(value) for key, _, value in (text.partition("=") for text in options.values)}
            values = values or from_output(sys.stdin)
            if not values:
                raise Mistake("there is no value to record: no KEY=VALUE, and no line `result KEY=VALUE` on stdin")
            record(values, **{field: getattr(options, field) for field in FIELDS[:4]})
            print(f"{len(values)} values stored in {RESULTS}; `make results` writes them into the documents")
        elif options.verb == "render":
            changed = render()
            print("\n".join(f"written: {path}" for path in changed) or "every document has the values of the file")
        elif found := check():
            print("\n".join(found), file=sys.stderr)
            return 1
    except Mistake as mistake:
        print(f"results.py: {mistake}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
