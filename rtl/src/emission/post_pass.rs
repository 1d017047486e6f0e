//! From rust-hdl's printed Verilog to one readable file per module: equal modules merged, plain names.
//!
//! rust-hdl names modules by their hierarchy (`top$column$0$lerp`), makes every instance a module of its own, joins
//! names by `$` and wires in one `always` block. Each source module gives its name in a line `// module: NAME`. Modules
//! with equal text are merged. Two different texts under one name are an error.
//!
//! A leaf of a family has a line `// family: NAME P=V ..` instead: its module is the file of the family, its ports must
//! be those that rust-hdl knows, and its instance gives the parameters. A module of wiring becomes one for all its
//! numbers by `// module: NAME P=INSTANCE.Q`, which takes its parameter from an instance in it, and
//! `// parameter: INSTANCE.Q=E`, which says how a parameter of an instance follows; each is compared with the number
//! that is there.
//!
//! Wiring becomes `assign` or goes into the port list, and `$` becomes `_`, checked for collisions. A name of
//! [`constant`] becomes its number, and arithmetic with numbers in a range is computed: `[STATE_BITS-1:0]` becomes
//! `[17:0]`.

use std::collections::BTreeMap;
use std::collections::HashSet;

use super::parameters::{self, Scope, Variant};
use crate::cells::family;
use crate::design::constant;

/// A module of the emission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Module {
    /// Name of the module, and of its file without `.v`.
    pub name: String,
    /// Text without banner.
    pub text: String,
}

/// An error in the sources that the post-pass finds.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EmissionError {
    /// The module has no line `// module: NAME`.
    #[error("module {0} does not say its name")]
    Nameless(String),
    /// Two different modules have one name.
    #[error("two different modules are called {name}: {first} and {second}")]
    Ambiguous {
        /// The name.
        name: String,
        /// The first module, as rust-hdl printed it.
        first: String,
        /// The second module.
        second: String,
    },
    /// Both `a$b` and `a_b` exist.
    #[error("module {module}: two signals become {name}")]
    Collision {
        /// The module.
        module: String,
        /// The name.
        name: String,
    },
    /// The ports in a family's file are not those of the cell.
    #[error("{module}: the file of family {family} has other ports than the cell: {found}, not {wanted}")]
    Ports {
        /// The module.
        module: String,
        /// The family.
        family: String,
        /// Directions, widths and names in the file.
        found: String,
        /// Those of the cell.
        wanted: String,
    },
    /// A parameter has another value than its module says.
    #[error("module {module}: `{line}`, but the value is {value}")]
    Parameter {
        /// The module.
        module: String,
        /// What it says.
        line: String,
        /// The value that the instance has.
        value: i64,
    },
    /// The printed text has an unknown form.
    #[error("module {module}: cannot read `{line}`")]
    Unknown {
        /// The module.
        module: String,
        /// The line.
        line: String,
    },
}

/// Rewrites rust-hdl's output as readable modules, children before parents.
///
/// # Errors
/// If the sources break the conventions above.
pub fn readable(printed: &str) -> Result<Vec<Module>, EmissionError> {
    // Parameters of a family have names of their own.
    let is_tag = |line: &str| line.trim().starts_with("// family: ");
    let printed = comments(printed);
    let lines = printed.split_inclusive('\n').map(|line| if is_tag(line) { line.to_owned() } else { numbers(line) });
    let printed: String = lines.collect();
    let mut raw = BTreeMap::new();
    let mut current: Option<(String, Vec<&str>)> = None;
    for line in printed.lines() {
        if let Some(rest) = line.trim_start().strip_prefix("module ").filter(|_| current.is_none()) {
            let name = rest.split('(').next().unwrap_or_default().to_owned();
            current = Some((name, Vec::new()));
        } else if line.trim_start().starts_with("endmodule") {
            if let Some((name, lines)) = current.take() {
                raw.insert(name, lines);
            }
        } else if let Some((_, lines)) = &mut current {
            lines.push(line);
        }
    }
    let mut pass = Pass { raw: &raw, names: BTreeMap::new(), modules: Vec::new(), origins: BTreeMap::new() };
    let roots: Vec<_> = raw.keys().filter(|name| !name.contains('$')).cloned().collect();
    for root in roots {
        pass.visit(&root)?;
    }
    Ok(pass.modules)
}

struct Pass<'a> {
    raw: &'a BTreeMap<String, Vec<&'a str>>,
    /// Printed name to the readable module and its parameters, with their text as an instance gives it.
    names: BTreeMap<String, (Variant, Vec<String>)>,
    modules: Vec<Module>,
    origins: BTreeMap<String, String>,
}

/// A signal of a module as declared.
struct Declaration {
    direction: &'static str,
    range: String,
    name: String,
}

struct Instance {
    module: String,
    name: String,
    ports: Vec<(String, String)>,
}

/// What rust-hdl has printed of a module.
struct Parts<'a> {
    ports: Vec<Declaration>,
    signals: Vec<Declaration>,
    constants: Vec<String>,
    instances: Vec<Instance>,
    /// The lines behind the declarations.
    body: Vec<&'a str>,
    /// The body is Verilog by hand and not wiring.
    custom: bool,
}

impl<'a> Parts<'a> {
    fn read(printed: &str, lines: &[&'a str]) -> Result<Self, EmissionError> {
        let unknown = |line: &str| EmissionError::Unknown { module: printed.into(), line: line.trim().into() };
        let (mut ports, mut signals, mut constants) = (Vec::new(), Vec::new(), Vec::new());
        let mut instances: Vec<Instance> = Vec::new();
        let (mut body, mut custom) = (Vec::new(), false);
        let mut rest = lines.iter().enumerate();
        while let Some((at, line)) = rest.next() {
            let text = line.trim();
            if text.is_empty() || (text.starts_with("//") && !text.starts_with("// Update code")) {
                continue;
            }
            if text.starts_with("// Update code") {
                custom = text.contains("custom");
                body = lines[at + 1..].to_vec();
                break;
            }
            if let Some(declared) = text.strip_prefix("input wire ") {
                ports.push(declaration("input", declared));
            } else if let Some(declared) =
                text.strip_prefix("output reg ").or_else(|| text.strip_prefix("output wire "))
            {
                ports.push(declaration("output", declared));
            } else if let Some(declared) = text.strip_prefix("reg ").or_else(|| text.strip_prefix("wire ")) {
                signals.push(declaration("", declared));
            } else if text.starts_with("localparam") {
                constants.push(text.split_whitespace().collect::<Vec<_>>().join(" "));
            } else if let Some((head, "")) = text.split_once('(') {
                let mut words = head.split_whitespace();
                let (Some(module), Some(name)) = (words.next(), words.next()) else { return Err(unknown(line)) };
                let mut instance = Instance { module: module.into(), name: name.into(), ports: Vec::new() };
                for (_, line) in rest.by_ref() {
                    let text = line.trim();
                    if text == ");" {
                        break;
                    }
                    if text.is_empty() {
                        continue;
                    }
                    let port = text.trim_start_matches('.').trim_end_matches(',').trim_end_matches(')');
                    let (port, signal) = port.split_once('(').ok_or_else(|| unknown(line))?;
                    instance.ports.push((port.into(), signal.into()));
                }
                instances.push(instance);
            } else {
                return Err(unknown(line));
            }
        }
        Ok(Self { ports, signals, constants, instances, body, custom })
    }
}

impl Pass<'_> {
    fn visit(&mut self, printed: &str) -> Result<(), EmissionError> {
        let raw = self.raw;
        let Parts { ports, signals, constants, instances, mut body, custom } = Parts::read(printed, &raw[printed])?;
        for instance in &instances {
            if !self.names.contains_key(&instance.module) {
                self.visit(&instance.module)?;
            }
        }
        let said = |start: &str| body.iter().filter_map(|line| line.trim().strip_prefix(start)).collect::<Vec<_>>();
        if let Some(tag) = said("// family: ").first() {
            let (variant, given) = of_family(printed, tag, &ports)?;
            let text = family(&variant.module).unwrap_or_default();
            // A family may be made of another one.
            for part in text.lines().filter_map(parameters::instance) {
                if let Some(text) = family(part.module) {
                    self.add(printed, Module { name: part.module.into(), text: text.into() })?;
                }
            }
            self.add(printed, Module { name: variant.module.clone(), text: text.into() })?;
            self.names.insert(printed.into(), (variant, given));
            return Ok(());
        }
        let tag = said("// module: ").first().copied().ok_or_else(|| EmissionError::Nameless(printed.into()))?;
        let (name, own) = tag.split_once(' ').unwrap_or((tag, ""));
        let own = self.own_parameters(printed, own, &instances)?;
        let given = self.given_parameters(printed, &said("// parameter: "), &own, &instances)?;
        body.retain(|line| !["// module: ", "// parameter: "].iter().any(|start| line.trim().starts_with(start)));

        let mut declared = HashSet::new();
        for signal in ports.iter().chain(&signals) {
            if !declared.insert(plain(&signal.name)) {
                return Err(EmissionError::Collision { module: printed.into(), name: plain(&signal.name) });
            }
        }
        let mut text = head(name, &own, &ports, if custom { "output reg " } else { "output wire" });
        for constant in &constants {
            text += &format!("{}\n", plain(constant));
        }
        if custom {
            text += "\n";
            // rust-hdl indents what it takes as it is.
            let dedented: Vec<_> = body.iter().map(|line| line.strip_prefix("    ").unwrap_or(line)).collect();
            text += dedented.join("\n").trim();
            text += "\n\nendmodule\n";
        } else {
            text += &self.wired(printed, &body, &signals, &instances, &given)?;
        }
        self.add(printed, Module { name: name.into(), text })?;
        let given = own.iter().map(|(_, value)| value.to_string()).collect();
        self.names.insert(printed.into(), (Variant { module: name.into(), parameters: own }, given));
        Ok(())
    }

    /// Adds a module, which may be there already with the same text.
    fn add(&mut self, printed: &str, module: Module) -> Result<(), EmissionError> {
        match self.origins.get(&module.name) {
            None => {
                self.origins.insert(module.name.clone(), printed.into());
                self.modules.push(module);
            }
            Some(_) if self.modules.contains(&module) => {}
            Some(first) => {
                let (name, first) = (module.name, first.clone());
                return Err(EmissionError::Ambiguous { name, first, second: printed.into() });
            }
        }
        Ok(())
    }

    /// The parameter of an instance, `INSTANCE.NAME`.
    fn parameter_at(&self, place: &str, instances: &[Instance]) -> Option<i64> {
        let (at, name) = place.split_once('.')?;
        let instance = instances.iter().find(|instance| plain(&instance.name) == at)?;
        self.names.get(&instance.module)?.0.parameter(name)
    }

    /// Reads the parameters of a module of wiring, `P=INSTANCE.Q` and blanks between.
    fn own_parameters(
        &self,
        printed: &str,
        said: &str,
        instances: &[Instance],
    ) -> Result<Vec<(String, i64)>, EmissionError> {
        let one = |line: &str| {
            let value = line
                .split_once('=')
                .and_then(|(name, place)| Some((name.to_owned(), self.parameter_at(place, instances)?)));
            value.ok_or_else(|| EmissionError::Unknown { module: printed.into(), line: line.into() })
        };
        said.split_whitespace().map(one).collect()
    }

    /// Reads how parameters of instances follow from those of the module, `INSTANCE.Q=E`, and compares the values.
    fn given_parameters(
        &self,
        printed: &str,
        said: &[&str],
        own: &[(String, i64)],
        instances: &[Instance],
    ) -> Result<BTreeMap<String, String>, EmissionError> {
        let scope: Scope = own.iter().cloned().collect();
        let one = |line: &&str| {
            let unknown = || EmissionError::Unknown { module: printed.into(), line: (*line).into() };
            let (place, text) = line.split_once('=').ok_or_else(unknown)?;
            let value = self.parameter_at(place, instances).ok_or_else(unknown)?;
            if parameters::value(text, &scope) != Some(value) {
                return Err(EmissionError::Parameter { module: printed.into(), line: (*line).into(), value });
            }
            Ok((place.to_owned(), text.to_owned()))
        };
        said.iter().map(one).collect()
    }

    /// The body of a module that only wires: assignments and instances.
    fn wired(
        &self,
        printed: &str,
        body: &[&str],
        signals: &[Declaration],
        instances: &[Instance],
        given: &BTreeMap<String, String>,
    ) -> Result<String, EmissionError> {
        let mut wires = BTreeMap::new();
        let mut statements = Vec::new();
        for line in body {
            let text = line.trim();
            match text {
                "" | "begin" | "end" | "always @(*) begin" => continue,
                _ => {}
            }
            if text.starts_with("//") {
                statements.push((text.to_owned(), String::new()));
            } else if let Some((target, value)) = text.strip_suffix(';').and_then(|text| text.split_once(" = ")) {
                wires.insert(target.to_owned(), value.to_owned());
                statements.push((target.to_owned(), value.to_owned()));
            } else {
                return Err(EmissionError::Unknown { module: printed.into(), line: text.into() });
            }
        }
        // An instance input that is wired takes the expression in its port list.
        let simple = |value: &str| !value.contains(['?', '{']);
        let inputs: HashSet<String> = instances
            .iter()
            .flat_map(|instance| instance.ports.iter().map(|(_, signal)| signal.clone()))
            .filter(|signal| wires.get(signal).is_some_and(|value| simple(value)))
            .collect();
        let mut text = String::from("\n");
        for signal in signals.iter().filter(|signal| !inputs.contains(&signal.name)) {
            text += &format!("wire {}{};\n", pad(&signal.range), plain(&signal.name));
        }
        let mut placed = vec![false; instances.len()];
        let instance_text = |instance: &Instance| {
            let (variant, texts) = &self.names[&instance.module];
            let name = plain(&instance.name);
            let one = |((parameter, _), text): (&(String, i64), &String)| {
                format!(".{parameter}({})", given.get(&format!("{name}.{parameter}")).unwrap_or(text))
            };
            let numbers: Vec<String> = variant.parameters.iter().zip(texts).map(one).collect();
            let numbers = if numbers.is_empty() { String::new() } else { format!(" #({})", numbers.join(", ")) };
            let mut text = format!("{}{numbers} {name} (\n", variant.module);
            for (i, (port, signal)) in instance.ports.iter().enumerate() {
                let value = if inputs.contains(signal) { &wires[signal] } else { signal };
                let comma = if i + 1 < instance.ports.len() { "," } else { "" };
                text += &format!("  .{}({}){comma}\n", plain(port), plain(value));
            }
            text + ");\n\n"
        };
        text += "\n";
        let mut assigns = String::new();
        for (target, value) in &statements {
            if value.is_empty() && target.starts_with("//") {
                text += &std::mem::take(&mut assigns);
                text += &format!("{target}\n");
                continue;
            }
            // An instance stands where its first input is wired.
            let owner = instances.iter().position(|instance| instance.ports.iter().any(|(_, signal)| signal == target));
            if let Some(owner) = owner.filter(|owner| !placed[*owner]) {
                placed[owner] = true;
                text += &instance_text(&instances[owner]);
            }
            if !inputs.contains(target) {
                assigns += &format!("assign {} = {};\n", plain(target), plain(value));
            }
        }
        for (instance, _) in instances.iter().zip(&placed).filter(|(_, placed)| !**placed) {
            text += &instance_text(instance);
        }
        text += &assigns;
        Ok(text.trim_end().to_owned() + "\n\nendmodule\n")
    }
}

/// Returns the head of a module, up to the end of its ports. The default of a parameter is 1: instances give others.
fn head(name: &str, parameters: &[(String, i64)], ports: &[Declaration], output: &str) -> String {
    let parameters: Vec<String> = parameters.iter().map(|(name, _)| format!("  parameter {name} = 1")).collect();
    let mut text = match parameters.is_empty() {
        true => format!("module {name} (\n"),
        false => format!("module {name} #(\n{}\n) (\n", parameters.join(",\n")),
    };
    for (i, port) in ports.iter().enumerate() {
        let kind = if port.direction == "input" { "input  wire" } else { output };
        let comma = if i + 1 < ports.len() { "," } else { "" };
        text += &format!("  {kind} {}{}{comma}\n", pad(&port.range), plain(&port.name));
    }
    text + ");\n"
}

/// Returns the module of a family with the parameters of a tag `NAME P=V ..`, and their texts.
///
/// # Errors
/// The family is unknown, or its ports are not those of the cell.
fn of_family(printed: &str, tag: &str, ports: &[Declaration]) -> Result<(Variant, Vec<String>), EmissionError> {
    let unknown = || EmissionError::Unknown { module: printed.into(), line: tag.into() };
    let mut words = tag.split_whitespace();
    let name = words.next().ok_or_else(unknown)?;
    let text = family(name).ok_or_else(unknown)?;
    let (mut values, mut texts) = (Vec::new(), Vec::new());
    for word in words {
        let (parameter, value) = word.split_once('=').ok_or_else(unknown)?;
        values.push((parameter.to_owned(), parameters::value(value, &Scope::new()).ok_or_else(unknown)?));
        texts.push(value.to_owned());
    }
    // In the order of the header, so that an instance reads as the module does.
    if !parameters::parameters(text).iter().map(|(name, _)| name).eq(values.iter().map(|(name, _)| name)) {
        return Err(unknown());
    }
    let variant = Variant { module: name.into(), parameters: values };
    let scope = variant.scope(text);
    let port = |is_output: bool, width: Option<i64>, name: &str| {
        let direction = if is_output { "output" } else { "input" };
        format!("{direction} {name} of {} bits", width.map_or("?".into(), |width| width.to_string()))
    };
    let found: Vec<String> =
        parameters::ports(text).iter().map(|it| port(it.is_output, it.width(&scope), &it.name)).collect();
    let wanted = |it: &Declaration| {
        let width = if it.range.is_empty() { Some(1) } else { parameters::width(&it.range, &Scope::new()) };
        port(it.direction == "output", width, &plain(&it.name))
    };
    let wanted: Vec<String> = ports.iter().map(wanted).collect();
    if found != wanted {
        let (found, wanted) = (found.join(", "), wanted.join(", "));
        return Err(EmissionError::Ports { module: printed.into(), family: name.into(), found, wanted });
    }
    Ok((variant, texts))
}

/// rust-hdl prints `comment!("text")` as the tokens `comment! ("text`, at times over two lines.
fn comments(printed: &str) -> String {
    let mut parts = printed.split("// comment!");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        text += "// ";
        text += part.trim_start().trim_start_matches("(\"");
    }
    text
}

/// Puts numbers in place of the constants of the design and of arithmetic with them between brackets.
fn numbers(text: &str) -> String {
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '$';
    let mut named = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_uppercase()) {
        // A name begins where the character before is of none.
        let whole = !rest[..start].ends_with(is_of_name);
        let end = rest[start..].find(|c| !is_of_name(c)).map_or(rest.len(), |length| start + length);
        let value = if whole { constant(&rest[start..end]) } else { None };
        named += &rest[..start];
        match value {
            Some(value) => named += &value.to_string(),
            None => named += &rest[start..end],
        }
        rest = &rest[end..];
    }
    named += rest;
    let mut folded = String::with_capacity(named.len());
    let mut rest = named.as_str();
    while let Some((before, (inside, after))) =
        rest.split_once('[').and_then(|(before, after)| Some((before, after.split_once(']')?)))
    {
        folded += before;
        folded.push('[');
        // An index inside of an index is left alone, and so is its outside.
        let (separator, parts) = match inside.split_once("+:") {
            Some(parts) => ("+:", Some(parts)),
            None => (":", inside.split_once(':')),
        };
        folded += &match parts {
            Some((high, low)) => format!("{}{separator}{}", number(high, separator == "+:"), number(low, false)),
            None => number(inside, false),
        };
        folded.push(']');
        rest = after;
    }
    folded + rest
}

/// A number for arithmetic with numbers, in the form in which rust-hdl prints numbers where one of them has it, or
/// where it is the `offset` of a slice of rust-hdl; other text as it is.
fn number(text: &str, offset: bool) -> String {
    let printed = text.contains("32'h") || offset && text.trim().starts_with('(');
    if !(text.contains(['+', '-', '*']) || printed && !text.contains("32'h")) {
        return text.to_owned();
    }
    let Some(value) = computed(text) else { return text.to_owned() };
    match (printed, text.trim().starts_with('(')) {
        (true, true) => format!("(32'h{value:x})"),
        (true, false) => format!("32'h{value:x}"),
        (false, _) => value.to_string(),
    }
}

/// The value of sums, differences and products of numbers; parentheses may stand around the whole.
fn computed(text: &str) -> Option<i64> {
    let text = text.trim();
    let text = text.strip_prefix('(').and_then(|inner| inner.strip_suffix(')')).unwrap_or(text);
    let factor = |text: &str| {
        let text = text.trim();
        text.strip_prefix("32'h").map_or_else(|| text.parse().ok(), |hex| i64::from_str_radix(hex, 16).ok())
    };
    let product = |text: &str| text.split('*').try_fold(1i64, |product, text| Some(product * factor(text)?));
    text.split('+').try_fold(0i64, |sum, text| {
        let mut terms = text.split('-');
        let first = product(terms.next()?)?;
        terms.try_fold(sum + first, |sum, term| Some(sum - product(term)?))
    })
}

fn declaration(direction: &'static str, declared: &str) -> Declaration {
    let declared = declared.trim().trim_end_matches(';');
    let (range, name) = match declared.split_once(']') {
        Some((range, name)) => (format!("{}]", range.trim()), name.trim()),
        None => (String::new(), declared),
    };
    Declaration { direction, range, name: name.into() }
}

fn pad(range: &str) -> String {
    if range.is_empty() { String::new() } else { format!("{range} ") }
}

/// `a$b` becomes `a_b`.
fn plain(name: &str) -> String {
    name.replace('$', "_")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DOG_BITS, STATE_BITS};

    #[test]
    fn constants_become_numbers_and_arithmetic_with_them_is_computed() {
        let (top, bits) = (STATE_BITS - 1, DOG_BITS);
        for (text, wanted) in [
            ("reg [STATE_BITS-1:0] y;", format!("reg [{top}:0] y;")),
            ("y[STATE_BITS] <= DOG_BITS'd0;", format!("y[{STATE_BITS}] <= {bits}'d0;")),
            ("points[16 * i +: DOG_BITS]", format!("points[16 * i +: {bits}]")),
            ("q[(32'h10)+:(16)] | r[32'h1f]", "q[(32'h10)+:(16)] | r[32'h1f]".into()),
            ("q[(32'h2 * DOG_BITS)+:(DOG_BITS)]", format!("q[(32'h{:x})+:({bits})]", 2 * bits)),
            ("q[(DOG_BITS)+:(1)] | r[DOG_BITS + 32'h1]", format!("q[(32'h{bits:x})+:(1)] | r[32'h{:x}]", bits + 1)),
            ("my_STATE_BITS STATE_BITS_ IDLE [i]", "my_STATE_BITS STATE_BITS_ IDLE [i]".into()),
        ] {
            assert_eq!(numbers(text), wanted);
        }
    }

    /// A delay of flags as rust-hdl prints it, with this tag and this declaration of its input.
    fn delay(name: &str, tag: &str, x: &str) -> String {
        format!(
            "module {name}(clock,reset,advance,x,y);\n    input wire clock;\n    input wire reset;\n    \
             input wire advance;\n    {x}\n    output reg y;\n\n    // Update code (custom)\n    // family: {tag}\n\
             endmodule\n"
        )
    }

    #[test]
    fn a_cell_of_a_family_has_the_ports_of_its_file() {
        let one = |tag: &str, x: &str| readable(&delay("cell", tag, x));
        let modules = one("flag_delay STEPS=3", "input wire x;").unwrap();
        assert_eq!((modules[0].name.as_str(), modules[0].text.as_str()), ("flag_delay", family("flag_delay").unwrap()));
        let other = one("flag_delay STEPS=3", "input wire [1:0] x;");
        assert!(matches!(other, Err(EmissionError::Ports { .. })), "{other:?}");
        for tag in ["flag_delay", "flag_delay BITS=3", "flag_delay STEPS=x", "no_such STEPS=3"] {
            let other = one(tag, "input wire x;");
            assert!(matches!(other, Err(EmissionError::Unknown { .. })), "{tag}: {other:?}");
        }
    }

    #[test]
    fn numbers_of_parts_follow_from_that_of_the_module() {
        let ports = |name: &str| {
            let one = |port| format!("        .{port}({name}${port})");
            ["clock", "reset", "advance", "x", "y"].map(one).join(",\n")
        };
        let wires = |name: &str| {
            ["clock", "reset", "advance", "x", "y"].map(|port| format!("    wire {name}${port};\n")).concat()
        };
        let stage = |said: &str| {
            format!(
                "{}{}module top(clock);\n    input wire clock;\n{}{}    top$a a(\n{}\n    );\n    \
                 top$b b(\n{}\n    );\n    // Update code\n    always @(*) begin\n    \
                 // module: stage DISTANCE=a.STEPS\n{said}    a$clock = clock;\n    end\nendmodule\n",
                delay("top$a", "flag_delay STEPS=2", "input wire x;"),
                delay("top$b", "flag_delay STEPS=6", "input wire x;"),
                wires("a"),
                wires("b"),
                ports("a"),
                ports("b"),
            )
        };
        let right = "    // parameter: a.STEPS=DISTANCE\n    // parameter: b.STEPS=DISTANCE + 4\n";
        let text = &readable(&stage(right)).unwrap()[1].text;
        for part in ["parameter DISTANCE = 1\n", "#(.STEPS(DISTANCE)) a (", "#(.STEPS(DISTANCE + 4)) b ("] {
            assert!(text.contains(part), "{text}");
        }
        // A number that nothing is said of stays one.
        assert!(readable(&stage("")).unwrap()[1].text.contains("#(.STEPS(6)) b ("));
        let wrong = readable(&stage("    // parameter: b.STEPS=DISTANCE + 5\n"));
        assert!(matches!(wrong, Err(EmissionError::Parameter { value: 6, .. })), "{wrong:?}");
        let missing = readable(&stage("    // parameter: c.STEPS=DISTANCE\n"));
        assert!(matches!(missing, Err(EmissionError::Unknown { .. })), "{missing:?}");
    }
}
