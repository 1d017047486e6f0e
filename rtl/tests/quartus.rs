//! What Quartus is given fits the emitted Verilog: ports, sources, names in the constraints; and the Tcl is Tcl.

use std::io::Write as _;
use std::{collections::BTreeSet, fs, path::Path, process::Command};

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn the_component_has_the_ports_of_the_top() {
    let top = read("verilog/hoverlock_top.v");
    let ports = top.split(");").next().unwrap().lines().filter_map(|line| {
        let line = line.trim().trim_end_matches(',');
        let (direction, rest) = line.split_once(' ').filter(|(word, _)| ["input", "output"].contains(word))?;
        let rest = rest.trim_start().strip_prefix("wire ")?;
        let (width, name) = match rest.strip_prefix('[') {
            Some(ranged) => {
                let (range, name) = ranged.split_once("] ")?;
                (range.split(':').next()?.parse::<u32>().ok()? + 1, name)
            }
            None => (1, rest),
        };
        Some((name.to_owned(), direction.to_owned(), width))
    });
    let ports: BTreeSet<_> = ports.collect();
    assert!(ports.len() > 15, "{ports:?}");
    let component = read("quartus/hoverlock_hw.tcl");
    let declared: BTreeSet<_> = component
        .lines()
        .filter_map(|line| {
            let words: Vec<&str> = line.strip_prefix("add_interface_port ")?.split_whitespace().collect();
            let [_, name, _, direction, width] = words[..] else { panic!("{line}") };
            Some((name.to_owned(), direction.to_lowercase(), width.parse().unwrap()))
        })
        .collect();
    assert_eq!(declared, ports);
}

#[test]
fn constraints_name_registers_that_exist() {
    let constraints = read("quartus/hoverlock.sdc");
    // `*module:instance|register[*]`
    let names: Vec<_> = constraints
        .lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(|line| line.split(['{', '}', ' ']))
        .filter(|word| word.starts_with('*'))
        .collect();
    assert_eq!(names.len(), 6, "{names:?}");
    let core = read("verilog/hoverlock_core.v");
    for name in names {
        let (module, rest) = name[1..].split_once(':').unwrap();
        let (instance, register) = rest.split_once('|').unwrap();
        assert!(core.contains(&format!("\n{module} {instance} (")), "{name}");
        let verilog = read(&format!("verilog/{module}.v"));
        let register = register.trim_end_matches("[*]");
        assert!(register == "*" || verilog.contains(&format!("] {register},\n")), "{name}");
    }
}

/// Every command that Quartus brings does nothing here but say its own name and what it was given.
const STUBS: &str = "
set folder [lindex $argv 0]
proc unknown {args} { global seen; lappend seen $args; return {} }
proc get_module_property {name} { global folder; return $folder }
proc package {args} {}
set seen {}
foreach file [lrange $argv 1 end] { cd $folder; source [file join $folder $file] }
if {[info procs add_sources] ne {}} { add_sources hoverlock_top }
foreach command $seen { puts $command }
";

#[test]
fn the_tcl_runs_and_takes_every_source() {
    let folder = tempfile::tempdir().unwrap();
    let stubs = folder.path().join("stubs.tcl");
    fs::write(&stubs, STUBS).unwrap();
    let quartus = Path::new(env!("CARGO_MANIFEST_DIR")).join("quartus");
    let run = |files: &[&str]| {
        let output = Command::new("tclsh").arg(&stubs).arg(&quartus).args(files).output().ok()?;
        assert!(output.status.success(), "{files:?}: {}", String::from_utf8_lossy(&output.stderr));
        Some(String::from_utf8(output.stdout).unwrap())
    };
    let Some(component) = run(&["hoverlock_hw.tcl"]) else {
        return writeln!(std::io::stderr(), "SKIPPED: the Platform Designer component: install tcl for tclsh")
            .expect("stderr is open");
    };
    let list = read("verilog/hoverlock.f");
    let sources: Vec<&str> = list.lines().filter(|line| line.ends_with(".v")).collect();
    let taken: Vec<&str> = component
        .lines()
        .filter_map(|line| line.strip_prefix("add_fileset_file ")?.split(' ').next())
        .filter(|name| name.ends_with(".v"))
        .collect();
    assert_eq!(taken, sources);
    assert!(component.contains("add_fileset_file hoverlock.sdc SDC PATH"));
    let constraints = run(&["example.sdc", "hoverlock.sdc"]).unwrap();
    assert!(
        constraints.contains("create_clock -name clock -period 10.000") && constraints.contains("set_multicycle_path")
    );
    let project = run(&["example.qsf"]).unwrap();
    assert_eq!(project.matches("VERILOG_FILE").count(), sources.len());
    for file in ["example.sdc", "hoverlock.sdc"] {
        assert!(project.contains(&format!("SDC_FILE {file}")));
    }
}
