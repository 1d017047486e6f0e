//! One build in its folder: runs Verilator, chooses the signals to make public, and has the C++ compiled.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::files::{read, write};
use super::generated::{Structures, Tables, driven_ports, drop_resets_of_members};
use super::hierarchy::{self, Hierarchy, PortDirection, Variable};
use super::ports::ports;
use super::tool::{self, Verilator, Version};
use super::unity::Overrides;
use super::unknown_warnings::UnknownWarnings;
use super::{Build, Initial, Record, Trace, diagnostic, modules_in};
use crate::engine::error::{BuildError, nearest};

/// The option that splits each `inout` of the top into an input and two outputs, value and enable. Older versions do
/// not have it.
const SPLIT_INOUTS: &str = "--pins-inout-enables";

/// The flags with which Verilator unrolls the loops over memories of up to 4096 words.
const UNROLL: [&str; 4] = ["--unroll-count", "4096", "--unroll-stmts", "1000000"];

/// A build in progress with its paths, all absolute.
pub(super) struct BuildJob<'a> {
    pub build: &'a Build,
    pub verilator: &'a Verilator,
    pub compiler: &'a Path,
    pub sources: &'a [PathBuf],
    pub includes: &'a [PathBuf],
    pub folder: &'a Path,
}

impl BuildJob<'_> {
    /// Runs Verilator and the compiler in the folder, which makes `model.so`. `runtime` gives the folder of the
    /// runtime's objects for a Verilator root.
    pub fn make(
        &self,
        version: &Version,
        runtime: impl FnOnce(&Path) -> Result<PathBuf, BuildError>,
    ) -> Result<Record, BuildError> {
        let root = self.verilator.root()?;
        let hierarchy = self.read_hierarchy(version)?;
        let forceable = self.choose_forceable(&hierarchy)?;
        let mut internals = self.choose_internals(&hierarchy)?;
        internals.extend(forceable.iter().filter(|v| !internals.contains(v)).cloned().collect::<Vec<_>>());
        let generated = self.folder.join("out");
        let of_top = hierarchy.variables.iter().filter(|v| v.port.is_some() && v.scope == self.build.top);
        // A build that splits them itself drives the halves itself.
        let split_by_flag = self.build.flags.iter().any(|flag| flag == SPLIT_INOUTS);
        let has_inouts = of_top.clone().any(|v| v.port == Some(PortDirection::Inout)) && !split_by_flag;
        let exposed = self.exposed(&internals, &hierarchy);
        let (mut warnings, drivable) = self.verilate_with_inouts(&exposed, &forceable, has_inouts)?;
        let mut tables = Tables::read(&generated)?;
        let unreachable = tables.unreachable(&generated)?;
        if !unreachable.is_empty() {
            let is_unreachable = |v: &&Variable| unreachable.contains(&(v.scope.clone(), v.name.clone()));
            let unreachable: HashSet<_> =
                internals.iter().filter(is_unreachable).map(|v| (&v.module, &v.name)).collect();
            let rest: Vec<Variable> =
                internals.iter().filter(|v| !unreachable.contains(&(&v.module, &v.name))).cloned().collect();
            std::fs::remove_dir_all(&generated)
                .map_err(|source| BuildError::Cache { path: generated.clone(), source })?;
            let forceable: Vec<Variable> = forceable.iter().filter(|v| rest.contains(v)).cloned().collect();
            warnings = self.verilate(&self.exposed(&rest, &hierarchy), &forceable, drivable)?;
            tables = Tables::read(&generated)?;
        }
        let header = read(&generated.join("Vdut.h"))?;
        let is_structure = |v: &&Variable| hierarchy.structures.contains_key(&v.path);
        let structured: Vec<&str> = of_top.clone().filter(is_structure).map(|v| v.name.as_str()).collect();
        let declared_as_number =
            if structured.is_empty() { HashSet::new() } else { drop_resets_of_members(&generated, &structured)? };
        let mut signals = ports(&header, &of_top.clone().collect::<Vec<_>>());
        signals.retain(|(port, _)| !declared_as_number.contains(&port.name));
        let mut unreachable: Vec<String> =
            of_top.filter(|v| !signals.iter().any(|(port, _)| port.name == v.name)).map(|v| v.path.clone()).collect();
        if self.build.registers {
            // Behind an output that is a register Verilator keeps a variable of its own, from which the port follows.
            for (variable, expression) in signals.iter_mut().filter(|(v, _)| v.register) {
                if let Some(behind) = tables.members.get(&(variable.scope.clone(), variable.name.clone())) {
                    expression.clone_from(behind);
                }
            }
        }
        let structures = Structures::read(&generated)?;
        for variable in std::mem::take(&mut internals) {
            let Some(member) = tables.members.get(&(variable.scope.clone(), variable.name.clone())) else {
                unreachable.push(variable.path);
                continue;
            };
            let Some(structure) = structures.of_member(member) else {
                signals.push((variable, member.clone()));
                continue;
            };
            for part in hierarchy.structures.get(&variable.path).into_iter().flatten() {
                if let Some(below) = structures.expression(structure, &part.steps) {
                    signals.push((part.variable.clone(), format!("{member}{below}")));
                }
            }
            unreachable.push(variable.path);
        }
        if drivable {
            // Only the two halves of an `inout` have such names: Verilator refuses a design that has them already.
            let is_half = |name: &str| {
                let of = name.strip_suffix("__out").or_else(|| name.strip_suffix("__en"));
                of.is_some_and(|of| signals.iter().any(|(v, _)| v.name == of && v.port == Some(PortDirection::Inout)))
            };
            let halves: Vec<bool> = signals.iter().map(|(v, _)| v.scope.is_empty() && is_half(&v.name)).collect();
            let mut halves = halves.into_iter();
            signals.retain(|_| !halves.next().unwrap_or(false));
        }
        if has_inouts && !drivable {
            // This version cannot split them. One that nothing inside drives is an input.
            let driven = driven_ports(&generated)?;
            let is_inout = |v: &Variable| v.port == Some(PortDirection::Inout) && !v.path.contains('.');
            for (variable, expression) in signals.iter_mut().filter(|(v, _)| is_inout(v)) {
                if !expression.strip_prefix("TOP.").is_some_and(|member| driven.contains(member)) {
                    variable.port = Some(PortDirection::Input);
                }
            }
        }
        let overrides = Overrides::new(&generated, &signals, &forceable, drivable)?;
        self.write_unity(&generated, &signals, &overrides)?;
        self.compile(&root, &generated, &runtime(&root)?)?;
        Ok(Record {
            top: self.build.top.clone(),
            signals: signals.into_iter().map(|(variable, _)| variable).collect(),
            unreachable,
            drivable_inouts: drivable || split_by_flag,
            constants: hierarchy.constants.iter().take(20_000).cloned().collect(),
            names: hierarchy.variables.iter().take(20_000).map(|v| v.path.clone()).collect(),
            trace: self.build.trace,
            coverage: self.build.coverage.any(),
            initial: self.build.initial,
            warnings,
            manifest: self.read_manifest(&generated, &root)?,
            library_hash: String::new(),
        })
    }

    /// Runs Verilator; once more where it does not have a warning that is turned off.
    fn verilator_command(&self, arguments: &[&str]) -> Result<std::process::Output, BuildError> {
        let mut unknown = UnknownWarnings::default();
        loop {
            let mut command = Command::new(&self.verilator.path);
            command.current_dir(self.folder).args(arguments);
            command.args(unknown.ignored_in(self.build.verilator_arguments(self.sources, self.includes)));
            // Verilator replaces `$name` in a path by a value: here by one that leaves the path unchanged.
            for path in self.sources.iter().chain(self.includes) {
                command.envs(variables_in(&path.to_string_lossy()));
            }
            let mut output = tool::run(&mut command)?;
            if output.status.success() || !unknown.add_from(&String::from_utf8_lossy(&output.stderr)) {
                output.stderr.extend(unknown.line().bytes());
                return Ok(output);
            }
        }
    }

    fn read_hierarchy(&self, version: &Version) -> Result<Hierarchy, BuildError> {
        if version.has_json() {
            let output = ["--json-only", "--json-only-output", "design.json", "--Mdir", "json"];
            self.check_output(&self.verilator_command(&output)?)?;
            return hierarchy::parse_json(&read(&self.folder.join("design.json"))?, &self.build.top);
        }
        // Optimised, the description would lack nets that are only another name of an expression.
        let output = self.verilator_command(&["--xml-only", "--xml-output", "design.xml", "--Mdir", "xml", "-O0"])?;
        self.check_output(&output)?;
        hierarchy::parse_xml(&read(&self.folder.join("design.xml"))?)
    }

    fn choose_internals(&self, hierarchy: &Hierarchy) -> Result<Vec<Variable>, BuildError> {
        let inner = || hierarchy.variables.iter().filter(|v| v.port.is_none() || v.path.contains('.'));
        for pattern in &self.build.internals {
            // `*` may match nothing.
            if pattern != "*" && !inner().any(|v| hierarchy::matches(pattern, &v.path)) {
                return Err(BuildError::NoSuchInternal {
                    name: pattern.clone(),
                    top: self.build.top.clone(),
                    nearest: nearest(pattern, inner().map(|v| v.path.as_str())),
                });
            }
        }
        // `*` means what modules declare: Verilator removes loop variables and the like.
        let wanted = |v: &&Variable| {
            self.build.registers && v.register && !v.nested
                || self.build.internals.iter().any(|p| hierarchy::matches(p, &v.path) && !(p == "*" && v.nested))
        };
        Ok(inner().filter(wanted).cloned().collect())
    }

    /// Returns the variables that are written from outside: the internals, and with [`Build::registers`] also the ports
    /// of the top that are registers.
    fn exposed(&self, internals: &[Variable], hierarchy: &Hierarchy) -> Vec<Variable> {
        let is_port = |v: &&Variable| v.port.is_some() && !v.path.contains('.');
        let ports = hierarchy.variables.iter().filter(|v| self.build.registers && v.register && is_port(v));
        internals.iter().chain(ports).cloned().collect()
    }

    /// Returns the variables to make forceable: those that a pattern names, of vectors.
    fn choose_forceable(&self, hierarchy: &Hierarchy) -> Result<Vec<Variable>, BuildError> {
        let refused = |name: &str, reason| BuildError::BadOption { what: "forceable", value: name.to_owned(), reason };
        let mut found: Vec<Variable> = Vec::new();
        for pattern in &self.build.forceable {
            let is_port = |v: &&Variable| v.port.is_some() && !v.path.contains('.');
            let matching = || hierarchy.variables.iter().filter(|v| hierarchy::matches(pattern, &v.path));
            let is_vector =
                |v: &&Variable| matches!(v.kind, hierarchy::Kind::Bits { .. }) && v.dimensions.is_empty() && !v.nested;
            let chosen: Vec<Variable> = matching().filter(|v| !is_port(v) && is_vector(v)).cloned().collect();
            if !chosen.is_empty() || pattern == "*" {
                found.extend(chosen);
            } else if matching().any(|v| is_port(&v)) {
                return Err(refused(pattern, "a port of the top: force the signal inside that drives it"));
            } else if matching().next().is_some() {
                return Err(refused(pattern, "no vector: arrays, `real` and variables of functions cannot be forced"));
            } else {
                return Err(BuildError::NoSuchInternal {
                    name: pattern.clone(),
                    top: self.build.top.clone(),
                    nearest: nearest(pattern, hierarchy.variables.iter().map(|v| v.path.as_str())),
                });
            }
        }
        Ok(found)
    }

    /// Runs Verilator; with the `inout`s of the top split into what comes in and what goes out, if this version can.
    /// The second value is `true` if it did.
    fn verilate_with_inouts(
        &self,
        internals: &[Variable],
        forceable: &[Variable],
        has_inouts: bool,
    ) -> Result<(Vec<diagnostic::Diagnostic>, bool), BuildError> {
        match self.verilate(internals, forceable, has_inouts) {
            Err(BuildError::Verilog { diagnostics })
                if diagnostics.iter().any(|d| d.message.contains(&format!("Invalid option: {SPLIT_INOUTS}"))) =>
            {
                Ok((self.verilate(internals, forceable, false)?, false))
            }
            other => other.map(|warnings| (warnings, has_inouts)),
        }
    }

    fn verilate(
        &self,
        internals: &[Variable],
        forceable: &[Variable],
        split_inouts: bool,
    ) -> Result<Vec<diagnostic::Diagnostic>, BuildError> {
        let mut config = String::from("`verilator_config\n");
        for (attribute, variables) in [("public_flat_rw", internals), ("forceable", forceable)] {
            let mut wanted: Vec<_> = variables.iter().map(|v| (v.module.as_str(), v.name.as_str())).collect();
            wanted.sort();
            wanted.dedup();
            for (module, variable) in wanted {
                // Writing to a String cannot fail.
                let _ = writeln!(config, "{attribute} -module \"{module}\" -var \"{variable}\"");
            }
        }
        write(&self.folder.join("public.vlt"), &config)?;
        let unique = match self.build.initial {
            Initial::Zero => "0",
            Initial::Random => "unique",
        };
        let mut arguments = vec!["--cc", "--prefix", "Vdut", "--Mdir", "out", "-O3", "--x-initial", unique];
        arguments.extend(["--x-assign", if self.build.initial == Initial::Random { "unique" } else { "0" }]);
        match self.build.trace {
            Trace::None => {}
            Trace::Vcd => arguments.extend(["--trace", "--trace-structs"]),
            Trace::Fst => arguments.extend(["--trace-fst", "--trace-structs"]),
        }
        let coverage = self.build.coverage;
        let kinds = [
            (coverage.line, "--coverage-line"),
            (coverage.toggle, "--coverage-toggle"),
            (coverage.user, "--coverage-user"),
        ];
        arguments.extend(kinds.iter().filter(|(on, _)| *on).map(|(_, flag)| *flag));
        if split_inouts {
            arguments.push(SPLIT_INOUTS);
        }
        if !forceable.is_empty() {
            // This optimiser of older versions puts the expression assigned in the place of the forced net.
            arguments.push("-fno-dfg");
        }
        arguments.push("public.vlt");
        let output = self.verilator_command(&arguments)?;
        let unrolled_by_flag = self.build.flags.iter().any(|flag| flag.starts_with("--unroll-count"));
        if !unrolled_by_flag && String::from_utf8_lossy(&output.stderr).contains("BLKLOOPINIT") {
            // Older versions take `<=` to the elements of an array in loops that they unroll, by default to 64 rounds.
            arguments.extend(UNROLL);
            return self.check_output(&self.verilator_command(&arguments)?);
        }
        self.check_output(&output)
    }

    /// Returns the warnings of a run that succeeded, or the error of one that failed.
    fn check_output(&self, output: &std::process::Output) -> Result<Vec<diagnostic::Diagnostic>, BuildError> {
        let text = String::from_utf8_lossy(&output.stderr);
        let mut diagnostics = diagnostic::parse(&text);
        diagnostics.iter_mut().for_each(|message| self.complete_name(message));
        if output.status.success() {
            return Ok(diagnostics);
        }
        if diagnostics.iter().any(|d| d.message.contains("--top-module") && d.message.contains("not found")) {
            let modules = modules_in(self.sources);
            let mut near = nearest(&self.build.top, modules.iter().map(String::as_str));
            if near.is_empty() {
                near = modules.into_iter().take(5).collect();
            }
            return Err(BuildError::NoSuchTop { top: self.build.top.clone(), nearest: near });
        }
        if diagnostics.is_empty() {
            let reason = format!("{} ({})", text.trim(), output.status);
            return Err(BuildError::Unexpected { what: "failure", reason });
        }
        Err(BuildError::Verilog { diagnostics })
    }

    /// Completes a file name that Verilator cut at its first blank: to the only source that begins so and has the
    /// quoted line. Verilator quotes the line after the preprocessor, so a line with a macro is not found and the name
    /// stays as it is.
    fn complete_name(&self, message: &mut diagnostic::Diagnostic) {
        let number = format!("{} | ", message.line);
        let Some(quoted) = message.context.iter().find_map(|line| line.trim_start().strip_prefix(&number)) else {
            return;
        };
        let is_meant = |source: &&PathBuf| {
            let goes_on =
                source.to_str().and_then(|s| s.strip_prefix(&message.file)).is_some_and(|s| s.starts_with(' '));
            let line = |text: String| text.lines().nth(message.line.saturating_sub(1) as usize).map(str::to_owned);
            goes_on && std::fs::read_to_string(source).ok().and_then(line).is_some_and(|l| l.trim_end() == quoted)
        };
        let mut meant = self.sources.iter().filter(is_meant);
        if let (Some(source), None) = (meant.next(), meant.next()) {
            message.file = source.display().to_string();
        }
    }
}

/// Finds `$name`, `${name}` and `$(name)` in a path; returns each name and its whole text.
fn variables_in(path: &str) -> Vec<(&str, &str)> {
    let variable = |(at, _): (usize, &str)| {
        let rest = &path[at + 1..];
        let bracket = usize::from(rest.starts_with(['{', '(']));
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let length = rest[bracket..].find(|c| !is_name(c)).unwrap_or(rest.len() - bracket);
        let name = rest.get(bracket..bracket + length).filter(|name| !name.is_empty())?;
        Some((name, path.get(at..at + 1 + length + 2 * bracket)?))
    };
    path.match_indices('$').filter_map(variable).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_in_paths_are_found() {
        let variables = [("b", "$b"), ("c", "${c}"), ("e", "$(e)"), ("g_1", "$g_1"), ("h", "$h"), ("j", "$j")];
        assert_eq!(variables_in("/a $b/${c}d/$(e)/$/f$g_1$h-i$j"), variables);
        assert_eq!(variables_in("/a/${b"), []);
    }
}
