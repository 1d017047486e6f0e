//! What Quartus is given: the Tcl runs in an interpreter with stubs of the commands of Quartus and Platform Designer.
//! What it calls is held against the rules of the Avalon interfaces, the Verilog, and the files that there are.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::{fs, path::Path, process::Command};

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_rtl::design::MAX_HEIGHT;
use hoverlock_rtl::emission::files_of;
use tempfile::TempDir;

/// The designs that come with the project.
const SHIPPED: [&str; 4] = ["kt27", "hd1080", "small", "three_scales"];

/// Every command that is not Tcl's own is printed with its arguments; `package` would look for Quartus.
const STUBS: &str = "
set folder [lindex $argv 0]
proc unknown {args} { puts [join $args \x1f]; return {} }
proc get_module_property {name} { global folder; return $folder }
proc package {args} {}
cd $folder
foreach file [lrange $argv 1 end] { source [file join $folder $file] }
foreach callback {add_sources add_verilog} {
    if {[info procs $callback] ne {}} { unknown fileset $callback; $callback hoverlock_component }
}
";

/// A command with its arguments.
type Call = Vec<String>;

/// Returns the calls of the Tcl files of a folder; `None` if there is no Tcl interpreter.
fn calls(folder: &Path, files: &[&str]) -> Option<Vec<Call>> {
    let stubs = tempfile::NamedTempFile::new().unwrap();
    fs::write(&stubs, STUBS).unwrap();
    let Ok(output) = Command::new("tclsh").arg(stubs.path()).arg(folder).args(files).output() else {
        writeln!(std::io::stderr(), "SKIPPED: what Quartus is given: install tcl for tclsh").expect("stderr is open");
        return None;
    };
    assert!(output.status.success(), "{files:?}: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    Some(text.lines().map(|line| line.split('\x1f').map(str::to_owned).collect()).collect())
}

fn read(path: impl AsRef<Path>) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn design(name: &str) -> DesignPoint {
    DesignPoint::shipped(name).unwrap()
}

/// The emission of a design as files.
fn emitted(design: &DesignPoint) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files_of(design).unwrap() {
        let path = folder.path().join(&file.path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, file.text).unwrap();
    }
    folder
}

/// Direction and width of each port of a module.
fn ports(verilog: &str) -> BTreeMap<String, (String, u32)> {
    let ports = verilog.split(");").next().unwrap().lines().filter_map(|line| {
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
        Some((name.to_owned(), (direction.to_owned(), width)))
    });
    ports.collect()
}

/// A port of an interface.
#[derive(Debug)]
struct Port {
    name: String,
    direction: String,
    width: u32,
}

/// An interface of a component.
#[derive(Debug, Default)]
struct Interface {
    kind: String,
    side: String,
    properties: BTreeMap<String, String>,
    /// By their roles.
    ports: BTreeMap<String, Port>,
}

impl Interface {
    fn number(&self, property: &str, default: u32) -> u32 {
        self.properties.get(property).map_or(default, |value| value.parse().unwrap_or(0))
    }

    fn width(&self, role: &str) -> Option<u32> {
        self.ports.get(role).map(|port| port.width)
    }
}

/// Of a kind of interface: its side, its properties, its roles with the direction at that side and a fixed width.
type Rules = (&'static str, &'static [&'static str], &'static [(&'static str, &'static str, Option<u32>)]);

/// As the Avalon Interface Specifications have them, as far as the component uses them.
fn rules(kind: &str) -> Option<Rules> {
    Some(match kind {
        "clock" => ("end", &["clockRate"], &[("clk", "Input", Some(1))]),
        "reset" => ("end", &["associatedClock", "synchronousEdges"], &[("reset", "Input", Some(1))]),
        "interrupt" => (
            "end",
            &["associatedAddressablePoint", "associatedClock", "associatedReset"],
            &[("irq", "Output", Some(1))],
        ),
        "avalon" => (
            "end",
            &["associatedClock", "associatedReset", "addressUnits", "readLatency", "readWaitTime", "writeWaitTime"],
            &[
                ("address", "Input", None),
                ("read", "Input", Some(1)),
                ("readdata", "Output", None),
                ("write", "Input", Some(1)),
                ("writedata", "Input", None),
            ],
        ),
        // The directions are those of a sink; a source has the others.
        "avalon_streaming" => (
            "either",
            &[
                "associatedClock",
                "associatedReset",
                "dataBitsPerSymbol",
                "symbolsPerBeat",
                "firstSymbolInHighOrderBits",
                "readyLatency",
            ],
            &[
                ("ready", "Output", Some(1)),
                ("valid", "Input", Some(1)),
                ("data", "Input", None),
                ("empty", "Input", None),
                ("startofpacket", "Input", Some(1)),
                ("endofpacket", "Input", Some(1)),
            ],
        ),
        _ => return None,
    })
}

/// The component as its Tcl declares it.
#[derive(Default)]
struct Component {
    interfaces: BTreeMap<String, Interface>,
    /// The files of each fileset, by its kind.
    files: BTreeMap<String, Vec<String>>,
    top_levels: BTreeSet<String>,
    faults: Vec<String>,
}

impl Component {
    fn of(calls: &[Call]) -> Self {
        let mut component = Self::default();
        let mut filesets: BTreeMap<String, String> = BTreeMap::new();
        let mut fileset = String::new();
        for call in calls {
            let words: Vec<&str> = call.iter().map(String::as_str).collect();
            match words[..] {
                ["set_module_property", _, _] => {}
                ["add_fileset", name, kind, callback] => {
                    filesets.insert(callback.to_owned(), kind.to_owned());
                    component.files.insert(kind.to_owned(), Vec::new());
                    component.top_levels.insert(format!("{name} has none"));
                }
                ["set_fileset_property", name, "TOP_LEVEL", top] => {
                    component.top_levels.remove(&format!("{name} has none"));
                    component.top_levels.insert(top.to_owned());
                }
                ["fileset", callback] => match filesets.get(callback) {
                    Some(kind) => fileset.clone_from(kind),
                    None => component.faults.push(format!("{callback} is of no fileset")),
                },
                ["add_fileset_file", name, "VERILOG" | "SDC", "PATH", path] => {
                    if !Path::new(path).is_file() {
                        component.faults.push(format!("{path}: no such file"));
                    }
                    component.files.entry(fileset.clone()).or_default().push(name.to_owned());
                }
                ["add_interface", name, kind, side] => component.interface(name, kind, side),
                ["set_interface_property", name, property, value] => component.property(name, property, value),
                ["add_interface_port", name, port, role, direction, width] => {
                    component.port(name, role, port, direction, width);
                }
                _ => component.faults.push(format!("no such command: {}", call.join(" "))),
            }
        }
        component
    }

    fn interface(&mut self, name: &str, kind: &str, side: &str) {
        let known = rules(kind).is_some_and(|(only, ..)| side == only || only == "either" && side == "start")
            || kind == "avalon_streaming" && side == "end";
        let new = Interface { kind: kind.into(), side: side.into(), ..Interface::default() };
        if !known || self.interfaces.insert(name.into(), new).is_some() {
            self.faults.push(format!("interface {name}: {kind} {side} is unknown, or there are two"));
        }
    }

    fn property(&mut self, name: &str, property: &str, value: &str) {
        let Some(interface) = self.interfaces.get_mut(name) else {
            return self.faults.push(format!("property {property} of no interface: {name}"));
        };
        let known = rules(&interface.kind).is_some_and(|(_, properties, _)| properties.contains(&property));
        if !known || interface.properties.insert(property.into(), value.into()).is_some() {
            self.faults.push(format!("{name}: property {property} is unknown, or set twice"));
        }
    }

    fn port(&mut self, name: &str, role: &str, port: &str, direction: &str, width: &str) {
        let Some(interface) = self.interfaces.get_mut(name) else {
            return self.faults.push(format!("port {port} of no interface: {name}"));
        };
        let roles = rules(&interface.kind).map(|(.., roles)| roles).unwrap_or_default();
        let width = width.parse().unwrap_or(0);
        let Some((_, at_end, fixed)) = roles.iter().find(|(known, ..)| *known == role) else {
            return self.faults.push(format!("{name}: no role {role} in {}", interface.kind));
        };
        let wanted = match (interface.side.as_str(), *at_end) {
            ("start", "Input") => "Output",
            ("start", _) => "Input",
            (_, at_end) => at_end,
        };
        if direction != wanted || width == 0 || fixed.is_some_and(|fixed| fixed != width) {
            self.faults.push(format!("{port}: {role} is {direction} {width}"));
        }
        let new = Port { name: port.into(), direction: direction.to_lowercase(), width };
        if interface.ports.insert(role.into(), new).is_some() {
            self.faults.push(format!("{name}: two ports are {role}"));
        }
    }

    /// Everything that is wrong, against the Verilog of the top.
    fn faults(mut self, verilog: &str) -> Vec<String> {
        let mut faults = std::mem::take(&mut self.faults);
        for (name, interface) in &self.interfaces {
            faults.extend(self.wrong(interface).into_iter().map(|what| format!("{name}: {what}")));
        }
        let mut left = ports(verilog);
        assert!(left.len() > 15, "{left:?}");
        for port in self.interfaces.values().flat_map(|interface| interface.ports.values()) {
            let there = left.remove(&port.name);
            if there.as_ref() != Some(&(port.direction.clone(), port.width)) {
                faults.push(format!("port {port:?} is {there:?} in the Verilog, or named twice"));
            }
        }
        faults.extend(left.keys().map(|port| format!("port {port} of the Verilog is in no interface")));
        let module = verilog.split_once("\nmodule ").unwrap().1.split(' ').next().unwrap().to_owned();
        if self.top_levels != BTreeSet::from([module]) {
            faults.push(format!("top levels {:?}", self.top_levels));
        }
        faults
    }

    fn wrong(&self, interface: &Interface) -> Vec<String> {
        let mut wrong = Vec::new();
        for (property, kind) in
            [("associatedClock", "clock"), ("associatedReset", "reset"), ("associatedAddressablePoint", "avalon")]
        {
            let needed = rules(&interface.kind).is_some_and(|(_, properties, _)| properties.contains(&property));
            let named = interface.properties.get(property).and_then(|name| self.interfaces.get(name));
            if needed && named.is_none_or(|named| named.kind != kind) {
                wrong.push(format!("{property} names no {kind} interface"));
            }
        }
        let roles = rules(&interface.kind).map(|(.., roles)| roles).unwrap_or_default();
        for (role, ..) in roles.iter().filter(|(role, ..)| *role != "empty" && !interface.ports.contains_key(*role)) {
            wrong.push(format!("no {role}"));
        }
        if interface.kind == "avalon_streaming" {
            wrong.extend(Self::wrong_stream(interface));
        }
        if interface.kind == "avalon" && interface.width("readdata") != interface.width("writedata") {
            wrong.push("readdata and writedata have different widths".into());
        }
        wrong
    }

    /// The rules of a stream with packets, and what a connection to a DMA master needs.
    fn wrong_stream(stream: &Interface) -> Vec<String> {
        let mut wrong = Vec::new();
        let (bits, symbols) = (stream.number("dataBitsPerSymbol", 8), stream.number("symbolsPerBeat", 1));
        if bits != 8 {
            wrong.push(format!("{bits} bits a symbol, DMA masters have 8"));
        }
        if stream.properties.get("firstSymbolInHighOrderBits").is_none_or(|high| high != "true") {
            wrong.push("the first symbol is in the highest bits at DMA masters".into());
        }
        if stream.number("readyLatency", 0) != 0 {
            wrong.push("DMA masters have a ready latency of 0".into());
        }
        if stream.width("data") != Some(symbols * bits) {
            wrong.push(format!("data of {symbols} symbols of {bits} bits is {:?} wide", stream.width("data")));
        }
        let log2 = symbols.next_power_of_two().trailing_zeros();
        if stream.width("empty") != (symbols > 1).then_some(log2) {
            wrong.push(format!("empty of {symbols} symbols is {:?} wide", stream.width("empty")));
        }
        wrong
    }
}

#[test]
fn the_component_keeps_the_rules_in_every_design() {
    for name in SHIPPED {
        let design = design(name);
        // The committed files of the default design.
        let folder = if design == *KT27 { None } else { Some(emitted(&design)) };
        let root = folder.as_ref().map_or(Path::new(env!("CARGO_MANIFEST_DIR")), |folder| folder.path());
        let quartus = root.join("quartus");
        let Some(calls) = calls(&quartus, &["hoverlock_hw.tcl"]) else { return };
        let component = Component::of(&calls);
        let list = read(root.join("verilog/hoverlock.f"));
        let mut sources = vec!["hoverlock_component.v"];
        sources.extend(list.lines().filter(|line| line.ends_with(".v")));
        assert_eq!(component.files["SIM_VERILOG"], sources, "{name}");
        sources.insert(0, "hoverlock.sdc");
        assert_eq!(component.files["QUARTUS_SYNTH"], sources, "{name}");
        assert_eq!(component.interfaces.len(), 6, "{name}");
        assert_eq!(component.faults(&read(quartus.join("hoverlock_component.v"))), [""; 0], "{name}");
    }
}

/// Each fault is put into the component of the default design, and found.
#[test]
fn faults_of_the_component_are_found() {
    let folder = emitted(&KT27);
    let quartus = folder.path().join("quartus");
    let (tcl, verilog) = (read(quartus.join("hoverlock_hw.tcl")), read(quartus.join("hoverlock_component.v")));
    for (good, bad, message) in [
        ("feature dataBitsPerSymbol 8", "feature dataBitsPerSymbol 256", "256 bits a symbol"),
        ("video symbolsPerBeat 2", "video symbolsPerBeat 1", "data of 1 symbols"),
        ("set_interface_property video symbolsPerBeat 2\n", "", "data of 1 symbols"),
        ("feature firstSymbolInHighOrderBits true", "feature firstSymbolInHighOrderBits false", "highest bits"),
        ("feature_empty empty Output 3", "feature_empty empty Output 4", "empty of 8 symbols is Some(4)"),
        ("add_interface_port video video_empty empty Input 1\n", "", "empty of 2 symbols is None"),
        ("video_empty empty Input", "video_empty empty Output", "video_empty: empty is Output 1"),
        ("feature_data data Output 64", "feature_data data Output 256", "is Some((\"output\", 64)) in the Verilog"),
        ("csr_read read Input 1", "csr_red read Input 1", "port csr_read of the Verilog is in no interface"),
        ("irq irq Output", "irq irq Input", "irq: irq is Input"),
        ("video_ready ready", "video_ready valid", "video: two ports are valid"),
        ("video readyLatency 0", "video readyLatency 1", "ready latency"),
        ("video readyLatency 0", "video readyLatncy 0", "property readyLatncy is unknown"),
        ("feature associatedClock clock", "feature associatedClock clk", "feature: associatedClock names no clock"),
        ("associatedAddressablePoint csr", "associatedAddressablePoint video", "names no avalon interface"),
        (
            "add_interface video avalon_streaming end",
            "add_interface video avalon_streaming start",
            "video_ready: ready is",
        ),
        ("synthesis TOP_LEVEL hoverlock_component", "synthesis TOP_LEVEL hoverlock_top", "top levels"),
        ("set_fileset_property synthesis TOP_LEVEL hoverlock_component\n", "", "top levels"),
        ("file join $here hoverlock_component.v", "file join $here component.v", "component.v: no such file"),
        ("add_interface_port clock", "add_interfce_port clock", "no such command: add_interfce_port"),
    ] {
        assert_eq!(tcl.matches(good).count(), 1, "{good}");
        fs::write(quartus.join("hoverlock_hw.tcl"), tcl.replace(good, bad)).unwrap();
        let Some(calls) = calls(&quartus, &["hoverlock_hw.tcl"]) else { return };
        let faults = Component::of(&calls).faults(&verilog);
        assert!(faults.iter().any(|fault| fault.contains(message)), "{bad}: {faults:#?}");
    }
}

/// Interfaces of Intel's cores by the names that their own Tcl gives them: kind, and direction as an export names it.
fn of_core(core: &str, parameters: &BTreeMap<String, String>) -> BTreeMap<String, (&'static str, &'static str)> {
    let dma = |name: &str| parameters.get(name).map(String::as_str);
    let interfaces: &[(&str, &str, &str)] = match (core, dma("MODE")) {
        ("clock_source", _) => &[
            ("clk_in", "clock", "sink"),
            ("clk_in_reset", "reset", "sink"),
            ("clk", "clock", "source"),
            ("clk_reset", "reset", "source"),
        ],
        ("altera_msgdma", Some("1")) => &[("mm_read", "avalon", "master"), ("st_source", "avalon_streaming", "source")],
        ("altera_msgdma", Some("2")) => &[
            ("mm_write", "avalon", "master"),
            ("st_sink", "avalon_streaming", "sink"),
            ("response", "avalon", "slave"),
        ],
        _ => panic!("no core {core} in mode {:?}", dma("MODE")),
    };
    let common: &[(&str, &str, &str)] = match core {
        "altera_msgdma" => &[
            ("clock", "clock", "sink"),
            ("reset_n", "reset", "sink"),
            ("csr", "avalon", "slave"),
            ("descriptor_slave", "avalon", "slave"),
            ("csr_irq", "interrupt", "sender"),
        ],
        _ => &[],
    };
    interfaces.iter().chain(common).map(|(name, kind, side)| ((*name).to_owned(), (*kind, *side))).collect()
}

/// Everything that is wrong with a system of the component and Intel's cores.
fn system_faults(calls: &[Call], component: &Component, largest_frame: u64) -> Vec<String> {
    let mut faults = Vec::new();
    let mut instances: BTreeMap<&str, (&str, BTreeMap<String, String>)> = BTreeMap::new();
    let (mut connections, mut exports, mut declared) = (Vec::new(), Vec::new(), BTreeMap::new());
    for call in calls {
        match call.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["create_system" | "save_system", _] | ["set_project_property", _, _] => {}
            ["add_instance", name, core] => drop(instances.insert(name, (core, BTreeMap::new()))),
            ["set_instance_parameter_value", name, parameter, value] => match instances.get_mut(name) {
                Some((_, parameters)) => drop(parameters.insert(parameter.into(), value.into())),
                None => faults.push(format!("no instance {name}")),
            },
            ["add_connection", from, to] => connections.push((from, to)),
            ["add_interface", name, kind, side] => drop(declared.insert(name, (kind, side))),
            ["set_interface_property", name, "EXPORT_OF", of] => exports.push((name, of)),
            _ => faults.push(format!("no such command: {}", call.join(" "))),
        }
    }
    let mut open: BTreeMap<String, (&str, &str)> = BTreeMap::new();
    for (name, (core, parameters)) in &instances {
        let interfaces = match *core {
            "hoverlock" => {
                component.interfaces.iter().map(|(name, interface)| (name.clone(), seen(interface))).collect()
            }
            core => of_core(core, parameters),
        };
        open.extend(interfaces.into_iter().map(|(interface, seen)| (format!("{name}.{interface}"), seen)));
    }
    let mut bound: BTreeMap<&str, u32> = BTreeMap::new();
    for (from, to) in &connections {
        let pair = open.get(*from).zip(open.get(*to));
        let fits = pair.is_some_and(|(from, to)| from.0 == to.0 && (from.1, to.1) == ("source", "sink"));
        if !fits {
            faults.push(format!("{from} to {to}: {pair:?}"));
        }
        for end in [from, to] {
            *bound.entry(end).or_default() += 1;
        }
    }
    for (name, of) in &exports {
        if open.get(*of) != declared.get(name) {
            faults.push(format!("{of} is {:?}, exported as {:?}", open.get(*of), declared.get(name)));
        }
        *bound.entry(of).or_default() += 1;
    }
    for (name, (kind, side)) in &open {
        let count = bound.get(name.as_str()).copied().unwrap_or_default();
        let many = *side == "source" && *kind != "avalon_streaming";
        if count == 0 || count > 1 && !many {
            faults.push(format!("{name} is connected or exported {count} times"));
        }
    }
    for (dma, stream, bytes) in [("frames", "video", largest_frame), ("features", "feature", 1)] {
        let parameter = |name: &str| instances[dma].1.get(name).and_then(|value| value.parse::<u64>().ok());
        let width = component.interfaces[stream].width("data").map(u64::from);
        if parameter("DATA_WIDTH") != width || parameter("PACKET_ENABLE") != Some(1) {
            faults.push(format!("{dma} has not the packets of {stream}, {width:?} bits"));
        }
        // The lengths that the core offers.
        let offered = |bytes: u64| bytes.is_power_of_two() && (1 << 10..=1 << 27).contains(&bytes);
        if !parameter("MAX_BYTE").is_some_and(|most| offered(most) && most >= bytes) {
            faults.push(format!("{dma}: a transfer of {bytes} bytes, MAX_BYTE {:?}", parameter("MAX_BYTE")));
        }
    }
    faults
}

/// Kind and direction of an interface of the component, as an export names them.
fn seen(interface: &Interface) -> (&'static str, &'static str) {
    match (interface.kind.as_str(), interface.side.as_str()) {
        ("clock", _) => ("clock", "sink"),
        ("reset", _) => ("reset", "sink"),
        ("interrupt", _) => ("interrupt", "sender"),
        ("avalon", _) => ("avalon", "slave"),
        (_, "start") => ("avalon_streaming", "source"),
        _ => ("avalon_streaming", "sink"),
    }
}

#[test]
fn the_example_system_connects_in_every_design() {
    for name in SHIPPED {
        let design = design(name);
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("quartus")).unwrap();
        fs::create_dir_all(folder.path().join("verilog")).unwrap();
        fs::write(folder.path().join("verilog/hoverlock.f"), "").unwrap();
        for file in hoverlock_rtl::emission::component::files(&design) {
            fs::write(folder.path().join(&file.path), file.text).unwrap();
        }
        let quartus = folder.path().join("quartus");
        let Some(declared) = calls(&quartus, &["hoverlock_hw.tcl"]) else { return };
        let component = Component::of(&declared);
        let largest = u64::from(design.width) * MAX_HEIGHT as u64 * u64::from(design.pixel.bits().div_ceil(8));
        let system = calls(&quartus, &["example_system.tcl"]).unwrap();
        assert_eq!(system_faults(&system, &component, largest), [""; 0], "{name}");
        // And each fault is found.
        let script = read(quartus.join("example_system.tcl"));
        for (good, bad, message) in [
            ("features DATA_WIDTH 64", "features DATA_WIDTH 256", "features has not the packets of feature"),
            ("frames PACKET_ENABLE 1", "frames PACKET_ENABLE 0", "frames has not the packets"),
            ("add_connection clk.clk features.clock\n", "", "features.clock is connected or exported 0 times"),
            ("hoverlock.feature features.st_sink", "features.st_sink hoverlock.feature", "features.st_sink to"),
            ("hoverlock.interrupt       interrupt sender", "hoverlock.interrupt avalon slave", "exported as"),
            ("frames.st_source hoverlock.video", "frames.st_source hoverlock.pixels", "None"),
            ("add_instance clk ", "add_instanc clk ", "no such command"),
        ] {
            assert_eq!(script.matches(good).count(), 1, "{good}");
            fs::write(quartus.join("faulty.tcl"), script.replace(good, bad)).unwrap();
            let faults = system_faults(&calls(&quartus, &["faulty.tcl"]).unwrap(), &component, largest);
            assert!(faults.iter().any(|fault| fault.contains(message)), "{bad}: {faults:#?}");
        }
        let faults = system_faults(&system, &component, 1 << 27 | 1);
        assert!(faults.iter().any(|fault| fault.contains("MAX_BYTE")), "{faults:#?}");
    }
}

#[test]
fn the_example_project_finds_its_files() {
    let quartus = Path::new(env!("CARGO_MANIFEST_DIR")).join("quartus");
    let Some(constraints) = calls(&quartus, &["example.sdc", "hoverlock.sdc"]) else { return };
    let has = |words: &str| constraints.iter().any(|call| call.join(" ").starts_with(words));
    assert!(has("create_clock -name clock -period 10.000") && has("set_multicycle_path"));
    let revision = read(quartus.join("example.qpf"));
    let revision = revision.lines().find_map(|line| line.strip_prefix("PROJECT_REVISION = ")).unwrap();
    assert_eq!(revision, "\"example\"");
    let project = calls(&quartus, &["example.qsf"]).unwrap();
    let assigned = |name: &str| -> Vec<&str> {
        let call = |call: &&Call| call[0] == "set_global_assignment" && call[1] == "-name" && call[2] == name;
        project.iter().filter(call).map(|call| call[3].as_str()).collect()
    };
    let list = read("verilog/hoverlock.f");
    let sources = assigned("VERILOG_FILE");
    assert_eq!(sources.len(), list.lines().filter(|line| line.ends_with(".v")).count());
    for file in sources.iter().chain(&assigned("SDC_FILE")) {
        assert!(quartus.join(file).is_file(), "{file}");
    }
    let top = assigned("TOP_LEVEL_ENTITY");
    assert!(sources.iter().any(|file| *file == format!("../verilog/{}.v", top[0])), "{top:?}");
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
        let verilog = read(format!("verilog/{module}.v"));
        let register = register.trim_end_matches("[*]");
        assert!(register == "*" || verilog.contains(&format!("] {register},\n")), "{name}");
    }
}
