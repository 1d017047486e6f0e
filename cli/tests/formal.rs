//! `hoverlock formal` from the command line.

#[path = "common/refusal.rs"]
mod refusal;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use hoverlock_formal::engine::find_program;
use refusal::assert_refused;
use serde_json::Value;

fn formal(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).arg("formal").args(args).output().unwrap()
}

fn results_of(output: &Output) -> Value {
    assert!(output.status.code() != Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Yosys and the solver are installed by `make test`.
fn installed() -> bool {
    let all = ["yosys", "yosys-smtbmc", "yices-smt2"].iter().all(|program| find_program(program).is_some());
    if !all {
        eprintln!("SKIPPED: no yosys or no yices-smt2; `make test` installs them");
    }
    all
}

/// A counter that must stay below ten: with its fault the proof names the property, and leaves a waveform.
const COUNTER: &str = "module counter (input clock, input reset, output reg [3:0] count);
always @(posedge clock)
  if (reset) count <= 4'd0;
  else count <= count == 4'd9 ? 4'd0 : count + 4'd1;
endmodule
";

const BELOW_TEN: &str = "module counter_properties (input clock, input reset);
  wire [3:0] count;
  counter dut (.clock(clock), .reset(reset), .count(count));
  reg begun = 0;
  always @(posedge clock) begin
    begun <= 1;
    if (!begun) assume (reset);
    else begin
      below_ten: assert (count < 4'd10);
      nine: cover (count == 4'd9);
    end
  end
endmodule
";

fn saved(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn verilog_of_the_users_is_proved_or_refuted_with_a_waveform() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let properties = saved(folder.path(), "below_ten.sv", BELOW_TEN);
    let out = folder.path().join("out");
    let run = |source: &str, depth: &str| {
        let out = out.to_str().unwrap();
        formal(&["--json", "--out", out, "--depth", depth, "--source", source, "--properties", &properties])
    };
    let source = saved(folder.path(), "good.v", COUNTER);
    let written = || fs::metadata(&source).unwrap().modified().unwrap();
    let before = written();
    let good = run(&source, "14");
    assert_eq!(written(), before, "the user's file is read and not written");
    let results = results_of(&good);
    assert_eq!((good.status.code(), &results["proved"], &results["failed"]), (Some(0), &1.into(), &0.into()));
    assert!(!out.exists());

    let bad = run(&saved(folder.path(), "bad.v", &COUNTER.replace("4'd9 ?", "4'd10 ?")), "14");
    let results = results_of(&bad);
    assert_eq!((bad.status.code(), &results["results"][0]["pass"]), (Some(1), &false.into()));
    let detail = results["results"][0]["detail"].as_str().unwrap();
    assert!(detail.starts_with("step ") && detail.ends_with("below_ten"), "{detail}");
    let trace = results["results"][0]["trace"].as_str().unwrap();
    assert!(fs::read_to_string(trace).unwrap().contains("count"));

    // Nine steps do not reach nine: the cover says so.
    let short = results_of(&run(&source, "5"));
    assert_eq!(short["results"][1]["status"], "failed");
    assert!(short["results"][1]["detail"].as_str().unwrap().contains("nine"), "{short}");
}

#[test]
fn covers_are_those_that_yosys_finds_and_their_absence_is_said() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let source = saved(folder.path(), "counter.v", COUNTER);
    let run = |cover: &str| {
        let text = BELOW_TEN.replace("nine: cover (count == 4'd9);", cover);
        let properties = saved(folder.path(), "below_ten.sv", &text);
        let out = folder.path().join("out");
        let out = out.to_str().unwrap();
        formal(&["--json", "--out", out, "--depth", "12", "--source", &source, "--properties", &properties])
    };
    let unreached = run("twelve: cover property (count == 4'd12);");
    let results = results_of(&unreached);
    assert_eq!((unreached.status.code(), &results["results"][1]["status"]), (Some(1), &"failed".into()), "{results}");
    // A comment is no cover.
    let none = run("// cover (count == 4'd9);");
    let (results, remark) = (results_of(&none), String::from_utf8_lossy(&none.stderr).into_owned());
    assert_eq!((none.status.code(), results["results"].as_array().unwrap().len()), (Some(0), 1), "{results}");
    assert!(remark.contains("below_ten: no covers"), "{remark}");
}

/// A value that passes from one clock to another.
const CROSSING: &str = "module crossing (input fast, input slow, input [3:0] d, output reg [3:0] q);
reg [3:0] a;
always @(posedge fast) a <= d;
always @(posedge slow) q <= a;
endmodule
";

const CROSSING_BELOW_TEN: &str = "module crossing_properties (input fast, input slow, input [3:0] d);
  wire [3:0] q;
  crossing dut (.fast(fast), .slow(slow), .d(d), .q(q));
  always @(posedge fast) below_ten: assert (q < 4'd10);
endmodule
";

#[test]
fn what_would_make_a_proof_meaningless_is_refused() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let run = |design: &str, properties: &str, more: &[&str]| {
        let source = saved(folder.path(), "design.v", design);
        let properties = saved(folder.path(), "rules.sv", properties);
        formal(&[&["--depth", "4", "--source", &source, "--properties", &properties], more].concat())
    };
    let both = "rules: registers have clock edges posedge fast and posedge slow, ";
    assert_refused(&run(CROSSING, CROSSING_BELOW_TEN, &[]), both);
    assert_refused(&run(CROSSING, CROSSING_BELOW_TEN, &["--coverage", "rules"]), both);
    let falling = CROSSING.replace("posedge slow", "negedge fast");
    assert_refused(&run(&falling, CROSSING_BELOW_TEN, &[]), "negedge fast and posedge fast");
    // The memory alone has the second clock.
    let memory = CROSSING
        .replace("reg [3:0] a;", "reg [3:0] a [0:3];")
        .replace("a <= d;", "a[d[1:0]] <= d;")
        .replace("q <= a;", "q <= a[d[3:2]];");
    let slow = CROSSING_BELOW_TEN.replace("posedge fast", "posedge slow");
    assert_refused(&run(&memory, &slow, &[]), both);
    let contradiction = BELOW_TEN.replace("begun <= 1;", "begun <= 1;\n    assume (!begun);");
    assert_refused(&run(COUNTER, &contradiction, &[]), "rules: no run of 5 steps satisfies the assumptions");
    let misspelt = BELOW_TEN
        .replace("  reg begun", "  (* hierconn *) wire [3:0] \\dut.counts ;\n  reg begun")
        .replace("assert (count <", "assert (\\dut.counts <");
    assert_refused(&run(COUNTER, &misspelt, &[]), "rules: the design has no wire dut.counts: ");
}

/// Two claims with all their faults, a few seconds each.
#[test]
fn small_claims_are_proved_and_their_faults_seen() {
    if !installed() {
        return;
    }
    let output = formal(&["--json", "--mutants", "difference", "column_maximum"]);
    let results = results_of(&output);
    assert_eq!((output.status.code(), &results["proved"]), (Some(0), &2.into()), "{results}");
    assert_eq!(results["results"].as_array().unwrap().len(), 8);
}

#[test]
#[ignore = "a minute and a half of proofs"]
fn every_claim_is_proved_and_its_faults_seen() {
    if !installed() {
        return;
    }
    let output = formal(&["--json", "--mutants"]);
    let results = results_of(&output);
    assert_eq!((output.status.code(), &results["failed"]), (Some(0), &0.into()), "{results}");
}

#[test]
fn claims_fit_one_scale_pair_and_are_not_stated_of_parity_bits() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, changes: &[&str]| {
        let file = folder.path().join(name).display().to_string();
        let changes = changes.iter().flat_map(|change| ["--config", change]);
        let new: Vec<&str> = ["design", "new", &file].into_iter().chain(changes).collect();
        let made = Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(new).output().unwrap();
        assert!(made.status.success(), "{made:?}");
        let out = folder.path().join("out").display().to_string();
        formal(&["csr", "--json", "--design", &file, "--out", &out])
    };
    let one = run("one.toml", &["scale_pairs=1", "sigmas=[2,3.2]", "look_ahead=[5,5]", "ring_radii=[12]"]);
    let results = results_of(&one);
    assert_eq!((one.status.code(), &results["proved"]), (Some(0), &1.into()), "{results}");
    let protected = run("protected.toml", &["protection=parity"]);
    let said = String::from_utf8_lossy(&protected.stderr).into_owned();
    assert!(protected.status.code() == Some(2) && said.contains("csr: its modules have parity bits"), "{said}");
}

/// All that the counter promises: its value after each clock.
fn exact() -> String {
    let state = "reg begun = 0, was_reset;\n  reg [3:0] was;";
    let exact = "assert (count == (was_reset || was == 4'd9 ? 4'd0 : was + 4'd1));";
    BELOW_TEN
        .replace("reg begun = 0;", state)
        .replace("begun <= 1;", "begun <= 1;\n    was <= count;\n    was_reset <= reset;")
        .replace("assert (count < 4'd10);", exact)
}

#[test]
fn mutations_survive_a_weak_claim_and_are_repeated_by_their_command() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let source = saved(folder.path(), "counter.v", COUNTER);
    let weak = saved(folder.path(), "weak.sv", BELOW_TEN);
    let strong = saved(folder.path(), "strong.sv", &exact());
    let run = |properties: &str, more: &[&str]| {
        let depth = ["--depth", "12", "--mutations", "30", "--seed", "1"];
        formal(&[&["--source", &source, "--properties", properties], &depth[..], more].concat())
    };
    let counts = |output: &Output| {
        let claim = &results_of(output)["claims"][0];
        let keys = ["drawn", "harmless", "killed", "survivors", "undecided"];
        keys.map(|key| claim[key].as_u64().unwrap())
    };
    // The counter has no state above nine, so two mutations of its comparison and its sum are harmless for both claims.
    let complete = run(&strong, &["--coverage", "strong", "--json"]);
    assert_eq!((complete.status.code(), counts(&complete)), (Some(0), [30, 2, 28, 0, 0]));
    let incomplete = run(&weak, &["--coverage", "weak", "--json"]);
    assert_eq!((incomplete.status.code(), counts(&incomplete)), (Some(1), [30, 2, 13, 15, 0]));
    let results = results_of(&incomplete);
    let survivor =
        results["claims"][0]["results"].as_array().unwrap().iter().find(|r| r["class"] == "survivor").unwrap();
    let number = survivor["number"].to_string();

    let again = run(&weak, &["--coverage", "weak", "--only", &number]);
    let text = String::from_utf8_lossy(&again.stdout).into_owned();
    assert_eq!(again.status.code(), Some(1), "{text}");
    assert!(text.contains(&format!("survivor {number}: ")) && text.contains("counter.v:"), "{text}");
    // The printed command gives the same result.
    let line = text.lines().find_map(|line| line.trim().strip_prefix("hoverlock formal ")).unwrap();
    let repeated = formal(&line.split(' ').collect::<Vec<_>>());
    assert!(String::from_utf8_lossy(&repeated.stdout).contains(&format!("survivor {number}: ")), "{line}");

    // A claim that does not hold would kill everything.
    let wrong = saved(folder.path(), "wrong.sv", &BELOW_TEN.replace("4'd10", "4'd9"));
    assert_refused(&run(&wrong, &["--coverage", "wrong"]), "not proved without a mutation");
}

/// A claim with modules that it abstracts, and one with abstract products.
#[test]
fn mutations_of_shipped_claims_are_classified() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let table = saved(folder.path(), "results.md", "# Results\n");
    let run = |claim: &str| formal(&["--json", "--coverage", claim, "--mutations", "20", "--table", &table]);
    for claim in ["decision", "cursor"] {
        let results = results_of(&run(claim));
        let of = &results["claims"][0];
        assert_eq!(of["drawn"], 20, "{results}");
        assert!(of["killed"].as_u64() >= Some(15) && of["undecided"] == 0, "{results}");
    }
    // Rows of other claims stay, in the order of the claims.
    let text = fs::read_to_string(&table).unwrap();
    assert!(text.starts_with("# Results\n\n## Coverage"), "{text}");
    assert!(
        text.find("| `decision` | 1 | 20 |") < text.find("| `cursor` | 1 | 20 |") && text.contains("`cursor`"),
        "{text}"
    );
}

#[test]
fn times_of_a_second_solver_are_entered_by_claim() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("table.md");
    for claim in ["cursor", "decision", "cursor"] {
        let output = formal(&[claim, "--solver", "z3", "--table", table.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }
    let text = fs::read_to_string(&table).unwrap();
    let rows: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    assert_eq!(rows, ["decision", "cursor"], "{text}");
}

#[test]
fn bad_input_is_one_line_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let counter = saved(folder.path(), "counter.v", COUNTER);
    let properties = saved(folder.path(), "below_ten.sv", BELOW_TEN);
    assert_refused(&formal(&["lerps"]), "lerps");
    assert_refused(&formal(&["--table", &format!("{counter}/results.md")]), "counter.v/results.md");
    assert_refused(&formal(&["--table", "results.csv"]), ".md");
    let no_text = folder.path().join("no_text.md");
    fs::write(&no_text, [0xff, 0xfe]).unwrap();
    for work in [&["decision"][..], &["--coverage", "decision"], &["decision", "--solver", "z3"]] {
        assert_refused(&formal(&[work, &["--table", no_text.to_str().unwrap()]].concat()), "no_text.md");
    }
    assert_eq!(fs::read(&no_text).unwrap(), [0xff, 0xfe]);
    assert_refused(&formal(&["--coverage", "lerps"]), "lerps");
    assert_refused(&formal(&["--coverage", "rounding"]), "no module");
    assert_refused(&formal(&["--coverage", "lerp", "--mutations", "0"]), "--mutations");
    assert_refused(&formal(&["--seed", "3"]), "--coverage");
    assert_refused(&formal(&["lerp", "--coverage", "lerp"]), "--coverage");
    assert_refused(&formal(&["--source", &counter]), "--properties");
    assert_refused(&formal(&["--source", folder.path().to_str().unwrap(), "--properties", &properties]), "is a folder");
    assert_refused(&formal(&["--source", "/nope.v", "--properties", &properties]), "/nope.v");
    assert_refused(&formal(&["--source", &counter, "--properties", "/nope.sv"]), "/nope.sv");
    if !installed() {
        return;
    }
    assert_refused(&formal(&["difference", "--rtl", folder.path().to_str().unwrap()]), "difference.v");
    let lacking = formal(&["component", "--rtl", folder.path().to_str().unwrap()]);
    assert_refused(&lacking, "no claim is stated for this Verilog: component: there is no ");
    let broken = saved(folder.path(), "broken.v", "module counter (input clock);\nassign a = ;\nendmodule\n");
    assert_refused(&formal(&["--source", &broken, "--properties", &properties]), "broken.v:2");
    let silent = saved(folder.path(), "silent.sv", "module silent (input clock);\n// assert (1);\nendmodule\n");
    assert_refused(&formal(&["--source", &counter, "--properties", &silent]), "no assert");
}

#[test]
fn worst_case_errors_are_proved_and_their_table_is_that_of_the_results() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("table.md");
    let output = formal(&["--json", "--mutants", "rounding", "saturation", "--table", table.to_str().unwrap()]);
    let results = results_of(&output);
    assert_eq!((output.status.code(), &results["proved"]), (Some(0), &2.into()), "{results}");
    assert_eq!(results["results"].as_array().unwrap().len(), 9);
    let section = |text: String| {
        let start = text.find("## Worst-case errors").expect("the table has no worst-case errors");
        text[start + 3..].split("\n## ").next().unwrap_or_default().to_owned()
    };
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../formal/RESULTS.md");
    let [now, committed] = [table, committed].map(|file| section(fs::read_to_string(file).unwrap()));
    assert_eq!(now, committed, "write it again: hoverlock formal --mutants --table formal/RESULTS.md");
}
