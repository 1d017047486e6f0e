"""Links of all documents, and the tables of ARCHITECTURE.md and the decisions against the workspace."""

import re
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\((?P<target>[^)\s#]*)(?:#(?P<anchor>[^)\s]+))?\)")
CODE = re.compile(r"```.*?```|`[^`\n]*`", re.DOTALL)


def documents():
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "*.md"], cwd=ROOT,
                            stdout=subprocess.PIPE, check=True, text=True).stdout
    return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]


def anchors(document: Path) -> set[str]:
    """The anchors that GitHub gives to the headings of a document."""
    text = re.sub(r"```.*?```", "", document.read_text(), flags=re.DOTALL)
    found = set()
    for heading in re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE):
        words = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", words).strip().replace(" ", "-")
        number = sum(1 for other in found if re.fullmatch(re.escape(anchor) + r"(-\d+)?", other))
        found.add(f"{anchor}-{number}" if number else anchor)
    return found


def test_every_link_leads_somewhere():
    broken = []
    for document in documents():
        text = CODE.sub("", document.read_text())
        for match in LINK.finditer(text):
            target, anchor = match["target"], match["anchor"]
            if "://" in target or target.startswith("mailto:"):
                continue
            path = (document.parent / target).resolve() if target else document
            here = f"{document.relative_to(ROOT)}: {match[0]}"
            if not path.exists():
                broken.append(here)
            elif anchor and path.suffix == ".md" and anchor not in anchors(path):
                broken.append(f"{here} has no such heading")
    assert not broken, "\n".join(broken)


def test_every_file_that_a_document_names_exists():
    tops = {path.split("/")[0] for path in subprocess.run(["git", "ls-files"], cwd=ROOT, stdout=subprocess.PIPE, check=True,
                                                          text=True).stdout.splitlines() if "/" in path}
    missing = []
    for document in documents():
        text = re.sub(r"```.*?```", "", document.read_text(), flags=re.DOTALL)
        for name in re.findall(r"`([\w.-]+(?:/[\w.-]+)+/?)`", text):
            # Changelog and decisions keep the names of their day.
            if document.name == "CHANGELOG.md" or document.parent.name == "decisions" or "NAME" in name or name.split("/")[0] not in tops | {"src", "tests", "benches", "examples"}:
                continue
            if not any((folder / name).exists() for folder in (ROOT, document.parent, document.parent.parent)):
                missing.append(f"{document.relative_to(ROOT)}: {name}")
    assert not missing, "\n".join(missing)


def section(heading: str) -> str:
    text = (ROOT / "ARCHITECTURE.md").read_text()
    return text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]


def test_every_library_has_its_reason_and_every_reason_its_library():
    dependencies = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["dependencies"]
    used = {table.get("package", name) if isinstance(table, dict) else name for name, table in dependencies.items()
            if not (isinstance(table, dict) and "path" in table)}
    rows = re.findall(r"^\| (`.+?) \|", section("Libraries"), flags=re.MULTILINE)
    explained = {name for row in rows for name in re.findall(r"`([^`]+)`", row)}
    assert used - explained == set(), "dependencies without a line in ARCHITECTURE.md"
    assert explained - used == set(), "lines of ARCHITECTURE.md without a dependency"


def crates() -> dict[str, set[str]]:
    """The folders of the crates, with those that each depends on; development dependencies apart."""
    members = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["members"]
    manifests = {member: tomllib.loads((ROOT / member / "Cargo.toml").read_text()) for member in members}
    folders = {manifest["package"]["name"]: member for member, manifest in manifests.items()}
    return {member: {folders[name] for name in manifest.get("dependencies", {}) if name in folders}
            for member, manifest in manifests.items()}


def test_the_map_has_every_crate_with_its_dependencies():
    rows = re.findall(r"^\| (\[`.+?) \| .+? \| ?(.*?) ?\|$", section("Crates"), flags=re.MULTILINE)
    described = {}
    for name, uses in rows:
        folders = re.findall(r"\[`([\w/]+?)/`\]", name)
        described |= {folder: set(uses.split(", ")) - {""} for folder in folders}
    # The plug-in has a line with the program that it counts, and depends on nothing.
    assert described.pop("arm/icount") == described["arm"]
    actual = crates()
    assert actual.pop("arm/icount") == set()
    assert described == actual


def test_dependencies_point_to_lines_below():
    lines = re.findall(r"^\d+  (.+)$", section("Crates"), flags=re.MULTILINE)
    height = {name: len(lines) - index for index, line in enumerate(lines) for name in line.split()}
    actual = crates()
    assert set(height) == set(actual)
    assert [(name, used) for name, uses in actual.items() for used in uses if height[used] >= height[name]] == []


def test_every_decision_is_listed():
    folder = ROOT / "docs/decisions"
    listed = dict(re.findall(r"^\| \[\d+\]\((\S+)\) \| (.+) \|$", (folder / "README.md").read_text(), flags=re.MULTILINE))
    titles = {}
    for path in sorted(folder.glob("[0-9]*.md")):
        number, title = re.fullmatch(r"# (\d+): (.+)", path.read_text().splitlines()[0]).groups()
        assert path.name.startswith(f"{number}-")
        titles[path.name] = title
    assert listed == titles
