//! From Verilog to a model: what is found again, what is built again, and every way it can fail.

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Instant;

use hoverlock_harness::BuildError;
use hoverlock_harness::build::{Build, Severity};

/// A folder with a cache of its own and some Verilog.
struct Place {
    folder: tempfile::TempDir,
}

/// A cache that all tests of this file, and all their runs, take the compiled runtime of Verilator from: compiling it
/// for each test would take minutes.
fn runtime() -> &'static Path {
    static RUNTIME: OnceLock<PathBuf> = OnceLock::new();
    RUNTIME.get_or_init(|| {
        let cache = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("runtime-cache");
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("constant.v");
        std::fs::write(&source, CONSTANT).unwrap();
        Build::new("constant").source(source).cache(&cache).compile().unwrap_or_else(|e| panic!("{e}"));
        cache.join("runtime")
    })
}

impl Place {
    fn new() -> Place {
        let place = Place { folder: tempfile::tempdir().unwrap() };
        std::fs::create_dir(place.path("cache")).unwrap();
        std::os::unix::fs::symlink(runtime(), place.path("cache/runtime")).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }

    fn build(&self, top: &str, text: &str) -> Build {
        Build::new(top).source(self.write(&format!("{top}.v"), text)).cache(self.path("cache"))
    }

    /// Built models in the cache.
    fn models(&self) -> usize {
        variants(&self.path("cache/models")).len()
    }
}

fn variants(models: &Path) -> Vec<PathBuf> {
    let list = |p: &Path| -> Vec<PathBuf> {
        std::fs::read_dir(p).map(|d| d.map(|e| e.unwrap().path()).collect()).unwrap_or_default()
    };
    list(models).iter().flat_map(|key| list(key)).collect()
}

/// Whether `VERILATOR` names one that the harness does not know.
fn is_newer() -> bool {
    let Ok(named) = std::env::var("VERILATOR") else { return false };
    Command::new(named).arg("--version").output().is_ok_and(|o| !o.stdout.starts_with(b"Verilator 5.0"))
}

/// What a module that drives a constant gives.
fn value(build: &Build) -> u64 {
    let mut model = build.compile().unwrap_or_else(|e| panic!("{e}")).instance().unwrap();
    model.eval().unwrap();
    let out = model.find("out").unwrap();
    model.get(out)
}

const CONSTANT: &str = "module constant #(parameter V = 1) (output wire [15:0] out);
`ifdef OTHER
  assign out = `OTHER;
`else
  assign out = V;
`endif
endmodule\n";

#[test]
fn what_matters_makes_a_new_model_and_what_does_not_finds_the_old_one() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    assert_eq!((value(&build), place.models()), (1, 1));
    let start = Instant::now();
    assert_eq!((value(&build), place.models()), (1, 1));
    let cached = start.elapsed();
    assert!(cached.as_millis() < 500, "a cached model took {cached:?}; 60 ms is the aim on a quiet machine");
    assert_eq!((value(&build.clone().parameter("V", 7)), place.models()), (7, 2));
    assert_eq!((value(&build.clone().define_as("OTHER", 9)), place.models()), (9, 3));
    place.write("constant.v", &CONSTANT.replace("V = 1", "V = 5"));
    assert_eq!((value(&build), place.models()), (5, 4));
    // Touched, but the same.
    place.write("constant.v", CONSTANT);
    assert_eq!((value(&build), place.models()), (1, 4));
}

#[test]
fn an_included_file_is_part_of_the_model_and_so_is_one_that_shadows_it() {
    let place = Place::new();
    let build = place
        .build(
            "includes",
            "`include \"value.vh\"\nmodule includes (output wire [15:0] out); assign out = `VALUE; endmodule\n",
        )
        .include(place.path("first"))
        .include(place.path("second"));
    std::fs::create_dir(place.path("first")).unwrap();
    place.write("second/value.vh", "`define VALUE 2\n");
    assert_eq!(value(&build), 2);
    place.write("second/value.vh", "`define VALUE 3\n");
    assert_eq!(value(&build), 3);
    place.write("second/value.vh", "`define VALUE 2\n");
    assert_eq!((value(&build), place.models()), (2, 2), "both are kept");
    place.write("first/value.vh", "`define VALUE 4\n");
    assert_eq!(value(&build), 4);
    std::fs::remove_file(place.path("first/value.vh")).unwrap();
    assert_eq!(value(&build), 2);
}

/// Blanks, a quote, and dollars before a variable that is set and one that is not.
#[test]
fn folders_and_files_may_have_any_name() {
    let place = Place::new();
    // Verilator takes the first name for a file too; here it is a folder.
    // Newer versions do not take a quotation mark in a name.
    let quote = if is_newer() { "it's ${nothing}" } else { "it's \"${nothing}\"" };
    for folder in ["one", &format!("one two $HOME/{quote}"), "plain/$LANG"] {
        let text = "`include \"the value.vh\"\nmodule named (input wire [7:0] in, output wire [15:0] out);\n  \
                    wire [3:0] narrow = in;\n  assign out = `VALUE;\nendmodule\n";
        let source = place.write(&format!("{folder}/top and all.v"), text);
        let include = format!("{folder}/inc $HOME/the value.vh");
        place.write(&include, "`define VALUE 2\n");
        let other = place.write(&format!("{folder}/top other.v"), "module other (input wire a);\n\n\nendmodule\n");
        let build = Build::new("named").source(&other).source(&source).include(place.path(&include).parent().unwrap());
        let build = build.cache(place.path(&format!("{folder}/cache of $HOME")));
        std::fs::create_dir(place.path(&format!("{folder}/cache of $HOME"))).unwrap();
        std::os::unix::fs::symlink(runtime(), place.path(&format!("{folder}/cache of $HOME/runtime"))).unwrap();
        let models = || variants(&place.path(&format!("{folder}/cache of $HOME/models"))).len();
        assert_eq!((value(&build), models()), (2, 1));
        assert_eq!((value(&build), models()), (2, 1), "found again");
        place.write(&include, "`define VALUE 3\n");
        assert_eq!((value(&build), models()), (3, 2), "the include changed");
        place.write(&include, "`define VALUE 2\n");
        assert_eq!((value(&build), models()), (2, 2), "both are kept");
        // Verilator cuts the file's name at the first blank: the source is found by the line.
        let library = build.compile().unwrap();
        let warning = &library.warnings()[0];
        assert_eq!((Path::new(&warning.file), warning.line), (source.as_path(), 3));
    }
}

#[test]
fn parameters_of_every_kind_reach_the_verilog() {
    let place = Place::new();
    let text = "module kinds #(parameter [63:0] BIG = 0, parameter signed [31:0] NEGATIVE = 0, parameter NAME = \"no\",
        parameter [7:0] RAW = 0)
        (output wire [63:0] out, output wire [31:0] negative, output wire named, output wire [7:0] raw);
        assign out = BIG; assign negative = NEGATIVE; assign named = NAME == \"yes\"; assign raw = RAW; endmodule\n";
    let build = place
        .build("kinds", text)
        .parameter("BIG", 0xdead_beef_0123_4567u64)
        .parameter("NEGATIVE", -5)
        .parameter("NAME", "yes")
        .parameter("RAW", hoverlock_harness::build::Parameter::Verilog("8'hA5".into()));
    let mut model = build.compile().unwrap().instance().unwrap();
    model.eval().unwrap();
    let get = |name: &str| model.get(model.find(name).unwrap());
    assert_eq!((get("out"), get("negative") as i32, get("named"), get("raw")), (0xdead_beef_0123_4567, -5, 1, 0xa5));
}

#[test]
fn errors_in_the_verilog_come_with_file_and_line() {
    let place = Place::new();
    let build = place.build("broken", "module broken (input wire a);\n  wire b = a &;\nendmodule\n");
    match build.compile() {
        Err(BuildError::Verilog { diagnostics }) => {
            assert_eq!((diagnostics[0].severity, diagnostics[0].line), (Severity::Error, 2));
            assert!(diagnostics[0].file.ends_with("broken.v") && diagnostics[0].message.contains("syntax error"));
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(place.models(), 0);
    assert_eq!(std::fs::read_dir(place.path("cache/aside")).unwrap().count(), 0, "nothing is left behind");
    let unknown = place.build("unknown", "module unknown (output wire o); nothing u (o); endmodule\n").compile();
    assert!(unknown.unwrap_err().to_string().contains("nothing"));
    let wrong = place.build("constant", CONSTANT).parameter("W", 3).compile().unwrap_err().to_string();
    assert!(wrong.contains("W"), "{wrong}");
}

#[test]
fn warnings_are_told_and_may_be_made_errors() {
    let place = Place::new();
    let text = "module narrow (input wire [7:0] a, output wire [3:0] out); assign out = a; endmodule\n";
    let build = place.build("narrow", text);
    let library = build.compile().unwrap();
    let code = if is_newer() { "WIDTHTRUNC" } else { "WIDTH" };
    assert_eq!((library.warnings()[0].code.as_str(), library.warnings()[0].line), (code, 1));
    assert_eq!(build.compile().unwrap().warnings().len(), 1, "from the cache too");
    assert!(matches!(build.warnings_are_errors(true).compile(), Err(BuildError::Verilog { .. })));
}

#[test]
fn warnings_of_a_newer_verilator_may_be_turned_off() {
    let place = Place::new();
    let text = "/* verilator lint_off LATERA */ // verilator lint_off LATERB\n".to_owned() + CONSTANT;
    let build = place.build("constant", &text).verilator_flag("-Wno-LATERC").verilator_flag("-Wno-LATERD");
    assert_eq!(value(&build), 1);
    let warnings = build.compile().unwrap().warnings().to_vec();
    assert!(warnings.iter().any(|w| w.message.ends_with("LATERA, LATERB, LATERC, LATERD")), "{warnings:?}");
    let wrong = build.verilator_flag("-Werror-LATERE").compile().unwrap_err().to_string();
    assert!(wrong.contains("-Werror-LATERE"), "{wrong}");
}

#[test]
fn wrong_names_are_answered_with_the_nearest() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    let wrong = Build::new("constnat").source(place.path("constant.v")).cache(place.path("cache")).compile();
    assert_eq!(wrong.unwrap_err().to_string(), "no module 'constnat' in the sources; nearest: constant");
    let inner = place
        .build(
            "outer",
            "module outer (input wire clk); reg [3:0] state; always @(posedge clk) state <= state + 1; endmodule\n",
        )
        .internal("stat");
    assert_eq!(inner.compile().unwrap_err().to_string(), "no internal signal 'stat' in 'outer'; nearest: state");
    let odd = build.clone().parameter("V; rm", 1).compile().unwrap_err().to_string();
    assert_eq!(odd, "parameter 'V; rm' is not valid: not a Verilog name");
    let none = Build::new("constant").compile().unwrap_err().to_string();
    assert_eq!(none, "no Verilog source was given for top module 'constant'");
    let missing = Build::new("constant").source("/nowhere/constant.v").compile().unwrap_err().to_string();
    assert!(missing.starts_with("/nowhere/constant.v: No such file"), "{missing}");
}

#[test]
fn a_missing_or_unknown_verilator_is_said_so() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    let error = build.clone().verilator("/nowhere/verilator").compile().unwrap_err();
    assert!(
        error.to_string().contains("/nowhere/verilator was not found: install it (Debian: apt-get install verilator)")
    );
    for version in ["4.038 2020-07-11", "5.040 2025-01-01", "nonsense"] {
        let fake = place.write("verilator", &format!("#!/bin/sh\necho Verilator {version}\n"));
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
        match build.clone().verilator(&fake).compile() {
            Err(BuildError::VersionUnsupported { found, .. }) => assert!(version.starts_with(&found)),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_cache_that_cannot_be_used_is_said_so() {
    let place = Place::new();
    let file = place.write("a_file", "not a folder");
    let error = place.build("constant", CONSTANT).cache(file.join("cache")).compile().unwrap_err().to_string();
    assert!(error.contains("cannot be used") && error.contains("HOVERLOCK_CACHE"), "{error}");
}

#[test]
fn a_damaged_cache_is_built_again() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    assert_eq!(value(&build), 1);
    let variant = variants(&place.path("cache/models"))[0].clone();
    type Damage = fn(&Path);
    let damages: [Damage; 4] = [
        // A file of its own each time: the loaded one must not change under the process.
        |v| {
            std::fs::remove_file(v.join("model.so")).unwrap();
            std::fs::write(v.join("model.so"), b"half a library").unwrap();
        },
        |v| std::fs::remove_file(v.join("model.so")).unwrap(),
        |v| std::fs::write(v.join("record.json"), b"{ \"top\": ").unwrap(),
        |v| std::fs::remove_file(v.join("record.json")).unwrap(),
    ];
    for damage in damages {
        damage(&variant);
        assert_eq!((value(&build), place.models()), (1, 1));
        assert!(variant.join("record.json").exists());
    }
}

#[test]
fn a_cache_that_cannot_be_written_gives_what_it_holds() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    assert_eq!(value(&build), 1);
    let cache = place.path("cache");
    // The first time the lock is there, the second time it is not.
    for _ in 0..2 {
        let set = |mode: &str| {
            let path = if mode == "a-w" { "-R" } else { "-Rf" };
            assert!(Command::new("chmod").args([path, mode]).arg(&cache).status().unwrap().success());
        };
        set("a-w");
        if std::fs::File::create(cache.join("locks/probe")).is_ok() {
            set("u+w");
            eprintln!("SKIPPED: a cache that cannot be written: this user writes everywhere");
            return;
        }
        assert_eq!(value(&build), 1);
        let other = build.clone().parameter("V", 2).compile().unwrap_err().to_string();
        assert!(other.contains("cache folder"), "{other}");
        set("u+w");
        std::fs::remove_dir_all(cache.join("locks")).unwrap();
        std::fs::create_dir(cache.join("locks")).unwrap();
    }
}

#[test]
fn a_damaged_runtime_is_compiled_again() {
    let place = Place::new();
    // A copy of its own, as other tests use the shared one.
    std::fs::remove_file(place.path("cache/runtime")).unwrap();
    let copied = Command::new("cp").arg("-r").arg(runtime()).arg(place.path("cache/runtime")).status().unwrap();
    assert!(copied.success());
    // Runtimes of other versions may lie beside it: all are damaged, and the one that is used is mended.
    let folders = std::fs::read_dir(place.path("cache/runtime")).unwrap();
    let objects: Vec<(PathBuf, Vec<u8>)> = folders
        .map(|folder| folder.unwrap().path().join("verilated_threads.o"))
        .filter_map(|object| Some((object.clone(), std::fs::read(object).ok()?)))
        .collect();
    for (object, whole) in &objects {
        std::fs::write(object, &whole[..whole.len() / 2]).unwrap();
    }
    assert_eq!(value(&place.build("constant", CONSTANT)), 1);
    let mended = objects.iter().filter(|(object, whole)| std::fs::read(object).unwrap() == *whole).count();
    assert_eq!(mended, 1, "of {}", objects.len());
}

#[test]
fn the_cache_stays_below_its_limit_and_keeps_what_was_used_last() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT).cache_limit(u64::MAX);
    value(&build);
    let one: u64 = variants(&place.path("cache/models"))[0].join("model.so").metadata().unwrap().len();
    let limited = build.cache_limit(one * 5 / 2);
    for number in 2..5u64 {
        std::thread::sleep(std::time::Duration::from_millis(20));
        assert_eq!(value(&limited.clone().parameter("V", number)), number);
        assert!(place.models() <= 2, "{}", place.models());
    }
}

#[test]
fn models_not_used_for_thirty_days_are_removed_unless_they_are_in_use() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    let models = || variants(&place.path("cache/models"));
    // Builds a model and sets its last use to some days ago.
    let made_and_used = |value_of_v: u64, days: u64| -> PathBuf {
        let before = models();
        assert_eq!(value(&build.clone().parameter("V", value_of_v)), value_of_v);
        let made = models().into_iter().find(|variant| !before.contains(variant)).unwrap();
        let used = std::fs::File::options().append(true).open(made.join("used")).unwrap();
        used.set_modified(std::time::SystemTime::now() - std::time::Duration::from_secs(days * 24 * 3600)).unwrap();
        made
    };
    let recent = made_and_used(2, 29);
    let in_use = made_and_used(3, 31);
    let key = in_use.parent().unwrap().file_name().unwrap();
    let lock = std::fs::File::open(place.path("cache/locks").join(key)).unwrap();
    lock.lock_shared().unwrap();
    let old = made_and_used(4, 31);
    let last = made_and_used(5, 31);
    assert!(recent.exists() && in_use.exists() && last.exists() && !old.exists());
    assert!(!old.parent().unwrap().exists(), "an empty folder is left");
    drop(lock);
    // Found again, a model counts as used now.
    assert_eq!(value(&build.clone().parameter("V", 5)), 5);
    made_and_used(6, 0);
    assert!(recent.exists() && last.exists() && !in_use.exists());
}

#[test]
fn the_folder_of_a_killed_build_is_removed_and_that_of_a_living_one_stays() {
    let place = Place::new();
    let aside = place.path("cache/aside");
    for name in ["build-dead", "build-alive"] {
        place.write(&format!("cache/aside/{name}/alive"), "");
    }
    let alive = std::fs::File::open(aside.join("build-alive/alive")).unwrap();
    alive.lock().unwrap();
    value(&place.build("constant", CONSTANT));
    assert!(!aside.join("build-dead").exists() && aside.join("build-alive").exists());
}

#[test]
fn a_build_that_is_killed_harms_nobody() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    // This very test program as another process, which builds in the same cache and is killed in the middle.
    let program = std::env::current_exe().unwrap();
    let mut child = Command::new(program)
        .args(["helper_builds_the_constant", "--exact", "--ignored"])
        .env("HOVERLOCK_TEST_PLACE", place.folder.path())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let aside = place.path("cache/aside");
    let busy = || std::fs::read_dir(&aside).map(|d| d.count()).unwrap_or(0) > 0;
    let start = Instant::now();
    while !busy() && start.elapsed().as_secs() < 20 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!((value(&build), place.models()), (1, 1));
    assert!(!busy(), "the dead build's folder is gone");
}

#[test]
fn processes_and_threads_that_build_the_same_build_it_once() {
    let place = Place::new();
    let build = place.build("constant", CONSTANT);
    let program = std::env::current_exe().unwrap();
    let children: Vec<_> = (0..2)
        .map(|_| {
            Command::new(&program)
                .args(["helper_builds_the_constant", "--exact", "--ignored"])
                .env("HOVERLOCK_TEST_PLACE", place.folder.path())
                .stdout(std::process::Stdio::null())
                .spawn()
                .unwrap()
        })
        .collect();
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| assert_eq!(value(&build), 1));
        }
    });
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    assert_eq!(place.models(), 1);
    let libraries = variants(&place.path("cache/models"));
    let made = libraries[0].join("model.so").metadata().unwrap().modified().unwrap();
    assert_eq!(value(&build), 1);
    assert_eq!(libraries[0].join("model.so").metadata().unwrap().modified().unwrap(), made, "not built again");
}

#[test]
#[ignore = "no test: other tests run it in a process of its own"]
fn helper_builds_the_constant() {
    if let Some(place) = std::env::var_os("HOVERLOCK_TEST_PLACE") {
        let place = PathBuf::from(place);
        let build = Build::new("constant").source(place.join("constant.v")).cache(place.join("cache"));
        assert_eq!(value(&build), 1);
    }
}

/// A Verilator that the harness does not know, if `VERILATOR` names one; it is made to compute wrong.
#[test]
fn a_newer_verilator_that_computes_wrong_is_refused() {
    let place = Place::new();
    let newer = std::env::var("VERILATOR").unwrap_or_default();
    if !is_newer() {
        eprintln!("SKIPPED: the trial of a newer Verilator: VERILATOR does not name one");
        return;
    }
    // What the design doubles, it trebles.
    let script = format!(
        "#!/bin/sh\n'{newer}' \"$@\" || exit 1\n[ -d out ] && sed -i 's/(2\\.0 \\*/(3.0 */' out/*.cpp\nexit 0\n"
    );
    let fake = place.write("verilator", &script);
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
    let build = place.build("constant", CONSTANT);
    let said = build.clone().verilator(&fake).compile().unwrap_err().to_string();
    assert!(said.contains("cannot be used: on a small design"), "{said}");
    assert!(said.ends_with("'scaled' is 0x400e000000000000, not 0x4004000000000000"), "{said}");
    assert_eq!(value(&build.verilator(&newer)), 1, "as it is, it passes");
}
