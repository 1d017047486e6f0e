"""`setup/results.py` in a small repository of its own, and the documents of this one."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import flights
import hold
import results

ENTRY = {"figure": "speed", "unit": "cycles/s", "conditions": "quiet machine", "command": "make bench", "date": "2026-01-02",
         "commit": "abc"}
TEMPLATE = "| way | speed | of C++ |\n|---|---|---|\n| Rust | {{ bench.rust : si }} | {{ bench.rust / bench.cpp : .2f }} |\n"


@pytest.fixture
def project(tmp_path):
    """A repository with one entry, one template and one document that agree."""
    (tmp_path / "docs/tables").mkdir(parents=True)
    entries = {"bench": ENTRY | {"values": {"rust": 90_000_000, "cpp": 75_000_000.0}}, "alm": ENTRY | {"value": 9667}}
    (tmp_path / "docs/results.json").write_text(json.dumps(entries))
    (tmp_path / "docs/tables/speed.md").write_text(TEMPLATE)
    (tmp_path / "README.md").write_text(
        "# Title\n\nIt takes <!-- result alm -->9667<!-- /result --> ALM.\n\n<!-- table speed -->\n| way | speed | of C++ |\n"
        "|---|---|---|\n| Rust | 90.0 M | 1.20 |\n<!-- /table -->\n"
    )
    subprocess.run(["git", "init", "--quiet"], cwd=tmp_path, check=True)
    return tmp_path


def edit(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def test_documents_that_agree_pass(project):
    assert results.check(project) == []
    assert results.render(project) == []


def test_an_inline_value_that_differs_is_named_with_line_key_values_and_command(project):
    edit(project / "README.md", "9667", "9659")
    assert results.check(project) == ["README.md:3: alm is '9659' here and '9667' in docs/results.json; run `make results`"]


def test_a_cell_that_differs_is_named_with_line_key_values_and_command(project):
    edit(project / "README.md", "1.20", "1.16")
    assert results.check(project) == [
        "README.md:8: bench.rust / bench.cpp : .2f is '1.16' here and '1.20' in docs/results.json; run `make results`"
    ]


def test_a_row_with_other_words_and_a_row_too_many_are_named(project):
    edit(project / "README.md", "| Rust |", "| C |")
    edit(project / "README.md", "<!-- /table", "| more |\n<!-- /table")
    other, longer = results.check(project)
    assert other.startswith("README.md:8: table speed reads '| C | 90.0 M | 1.20 |' here")
    assert longer.startswith("README.md:9: table speed has 4 lines here and 3 in its template")


def test_render_mends_what_check_finds(project):
    before = (project / "README.md").read_text()
    edit(project / "README.md", "9667", "9659")
    edit(project / "README.md", "| Rust | 90.0 M | 1.20 |\n", "")
    assert results.render(project) == [Path("README.md")]
    assert (project / "README.md").read_text() == before


def test_an_entry_or_a_template_that_no_document_shows_fails(project):
    edit(project / "README.md", "<!-- result alm -->9667<!-- /result -->", "many")
    (project / "docs/tables/old.md").write_text("| |\n")
    assert results.check(project) == [
        "docs/results.json: no document shows alm; remove it or add it to a table",
        "docs/tables/old.md: no document has this table",
    ]


@pytest.mark.parametrize(("mark", "message"), [
    ("<!-- result nothing -->1<!-- /result -->", "docs/results.json has no nothing"),
    ("<!-- result bench.go -->1<!-- /result -->", "bench has no value go"),
    ("<!-- result bench -->1<!-- /result -->", "bench has several values: rust, cpp"),
    ("<!-- result alm % 2 -->1<!-- /result -->", "the operator % is not one of + - * /"),
    ("<!-- result alm / -->1<!-- /result -->", "an operand is missing"),
    ("<!-- result alm @ weather -->1<!-- /result -->", "not one of figure, unit"),
    ("<!-- result alm : s -->1<!-- /result -->", "format `s` of 9667"),
    ("<!-- table nothing -->\n<!-- /table -->", "no template docs/tables/nothing.md"),
    ("<!-- result alm -->9667", "is not closed"),
])
def test_a_mistake_in_a_document_is_one_line_with_its_name(project, mark, message):
    (project / "other.md").write_text(f"{mark}\n")
    (found,) = results.check(project)
    assert found.startswith("other.md") and message in found


@pytest.mark.parametrize(("value", "form", "text"), [
    (93_900_000, "si", "93.9 M"), (1_190_000, "si", "1.19 M"), (610_000, "si", "610 k"), (88_800, "si", "88.8 k"),
    (2_400, "si", "2.40 k"), (317, "si", "317"), (0.64, "", "0.64"), (34.157, ".0f", "34"), ("x", "", "x"),
    (999_600, "si", "1.00 M"), (99_960, "si", "100 k"), (9.996, "si", "10.0"),
])
def test_formats(value, form, text):
    assert results.formatted(value, form) == text


def test_expressions_are_from_left_to_right_and_fields_by_name(project):
    entries = results.Results(project)
    assert entries.expression("alm - 7 / 2 : .1f") == "4830.0"
    assert entries.expression("100 * bench.rust / bench.cpp : .0f") == "120"
    assert entries.expression("alm @ unit") == "cycles/s"
    assert entries.expression("bench @ source") == "2026-01-02, commit abc, `make bench`"


def test_recording_keeps_fields_and_sets_value_date_and_commit(project):
    results.record({"bench.rust": 1.5e6, "alm": 9700}, root=project, conditions="busy machine")
    entries = results.Results(project).entries
    assert entries["bench"]["values"] == {"rust": 1.5e6, "cpp": 75e6}
    assert entries["alm"]["value"] == 9700 and entries["alm"]["command"] == "make bench"
    assert entries["alm"]["conditions"] == "busy machine"
    assert entries["alm"]["date"] != ENTRY["date"] and entries["alm"]["commit"] != ENTRY["commit"]
    assert [path.name for path in (project / "docs").iterdir() if path.is_file()] == ["results.json"]


def test_a_new_entry_needs_its_fields_and_a_refused_one_leaves_the_file(project):
    before = (project / "docs/results.json").read_text()
    with pytest.raises(results.Mistake, match="new.key is new: give its figure"):
        results.record({"alm": 1, "new.key": 2}, root=project)
    with pytest.raises(results.Mistake, match="alm has one value"):
        results.record({"alm.mean": 1}, root=project)
    assert (project / "docs/results.json").read_text() == before
    results.record({"new.key": 2, "new.group": {"a": 1}}, root=project, figure="f", unit="1", conditions="c", command="m")
    assert results.Results(project).value("new.key") == 2
    assert results.Results(project).value("new.group.a") == 1


def test_lines_of_a_bench_are_picked_from_its_output(capsys):
    values = results.from_output(["a table\n", "result bench.rust=12.5\n", "result bench.name=x\n", "result of it\n"])
    assert values == {"bench.rust": 12.5, "bench.name": "x"}
    assert capsys.readouterr().out == "a table\nresult of it\n"


def test_a_file_without_a_field_is_refused(project):
    edit(project / "docs/results.json", '"commit": "abc", "value"', '"value"')
    with pytest.raises(results.Mistake, match="alm has no commit"):
        results.check(project)


def test_the_flights_of_the_table_are_those_of_the_file():
    entries, rows = results.Results().entries, hold.flights()
    recorded = {key: entry["values"] for key, entry in entries.items() if key.startswith("hold.")}
    assert recorded == hold.summaries(rows) | {"hold.imu_only": hold.imu_only(rows)}
    assert {entries[key]["commit"] for key in recorded} == {results.commits(rows)}


def test_the_random_flights_of_the_table_are_those_of_the_file():
    entries = results.Results().entries
    recorded = {key: entry["values"] for key, entry in entries.items() if key.startswith("flights.random.")}
    assert recorded == flights.summaries(flights.flights())
    assert {entries[key]["commit"] for key in recorded} == {results.commits(flights.flights())}


def test_the_nees_of_an_ingredient_is_that_of_the_flights_that_have_it():
    rows = [{"nees": "1.0", "ingredients": "height=18 ground=town black=0.30"}, {"nees": "4.0", "ingredients": "height=90 ground=grass black=1.2"}]
    assert flights.nees_by_ingredient(rows) == {"ground town": 1.0, "ground grass": 4.0, "black": 2.5}


def test_a_result_recorded_before_is_no_change_of_the_program(project):
    run = lambda *arguments: subprocess.run(["git", *arguments], cwd=project, check=True, stdout=subprocess.PIPE)
    (project / "program.rs").write_text("fn main() {}")
    run("add", ".")
    run("-c", "user.name=a", "-c", "user.email=a@b", "commit", "--quiet", "--message", "first")
    results.record({"alm": 9700}, root=project)
    results.record({"alm": 9701}, root=project)
    assert re.fullmatch("[0-9a-f]{8}", results.Results(project).entries["alm"]["commit"])
    (project / "program.rs").write_text("fn main() { }")
    results.record({"alm": 9702}, root=project)
    assert results.Results(project).entries["alm"]["commit"].endswith("-dirty")


def test_flights_have_the_commits_that_flew_them(project):
    rows = [{"commit": commit} for commit in ("0123456789ab", "0123456789ab", "89abcdef0123-dirty")]
    assert results.commits(rows) == "01234567, 89abcdef-dirty"
    results.record({"alm": 9700}, root=project, commit=results.commits(rows))
    assert results.Results(project).entries["alm"]["commit"] == "01234567, 89abcdef-dirty"


def test_the_counts_of_written_tables_are_those_of_the_file():
    """`hoverlock formal --table` and the mutation test write their tables themselves."""
    entries = results.Results()
    rows = re.findall(r"^\| `\w+` \| .+ \| (\d+) of (\d+) \|$", (results.ROOT / "formal/RESULTS.md").read_text(), re.MULTILINE)
    counts = {"claims": len(rows), "mutants": sum(int(of) for _, of in rows), "mutants_seen": sum(int(seen) for seen, _ in rows)}
    assert counts == entries.entries["formal.claims"]["values"]
    head = (results.ROOT / "rtl/MUTANTS.md").read_text().split("\n\n")[1]
    faults, possible, found, harmless = map(int, re.findall(r"(\d+) (?:faults|possible|found|harmless)", head))
    assert entries.entries["rtl.mutants"]["values"] == {"faults": faults, "possible": possible, "found": found, "harmless": harmless}


def test_the_documents_of_this_project_agree_with_the_file():
    assert results.check() == []
