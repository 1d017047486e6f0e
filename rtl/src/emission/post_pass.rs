//! From rust-hdl's printed Verilog to one readable file per module: equal modules merged, plain names.
//!
//! rust-hdl names modules by their hierarchy (`top$column$0$lerp`), makes every instance a module of its own, joins
//! names by `$` and wires in one `always` block. Each source module gives its name in a line `// module: NAME`. Modules
//! with equal text are merged. Two different texts under one name are an error; a name that ends in `*` is numbered.
//! Wiring becomes `assign` or goes into the port list, and `$` becomes `_`, checked for collisions. A name of
//! [`constant`] becomes its number, and arithmetic with numbers in a range is computed: `[STATE_BITS-1:0]` becomes
//! `[17:0]`.

use std::collections::BTreeMap;
use std::collections::HashSet;

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
    let printed = numbers(&comments(printed));
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
    /// Printed name to readable name.
    names: BTreeMap<String, String>,
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

impl Pass<'_> {
    fn visit(&mut self, printed: &str) -> Result<(), EmissionError> {
        let lines = self.raw[printed].clone();
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
        for instance in &instances {
            if !self.names.contains_key(&instance.module) {
                self.visit(&instance.module)?;
            }
        }
        let tag = body.iter().find_map(|line| line.trim().strip_prefix("// module: ")).map(str::to_owned);
        let tag = tag.ok_or_else(|| EmissionError::Nameless(printed.into()))?;
        let header: Vec<String> =
            body.iter().filter_map(|line| line.trim().strip_prefix("// :").map(str::to_owned)).collect();
        body.retain(|line| !line.trim().starts_with("// module: ") && !line.trim().starts_with("// :"));

        let mut declared = HashSet::new();
        for signal in ports.iter().chain(&signals) {
            if !declared.insert(plain(&signal.name)) {
                return Err(EmissionError::Collision { module: printed.into(), name: plain(&signal.name) });
            }
        }
        let mut text = String::new();
        for line in header {
            text += &format!("//{line}\n");
        }
        text += "module NAME (\n";
        let driven_by_assign = !custom;
        for (i, port) in ports.iter().enumerate() {
            let kind = if port.direction == "output" && !driven_by_assign { "output reg " } else { "" };
            let kind = match (port.direction, kind) {
                ("input", _) => "input  wire",
                (_, "") => "output wire",
                _ => "output reg ",
            };
            let comma = if i + 1 < ports.len() { "," } else { "" };
            text += &format!("  {kind} {}{}{comma}\n", pad(&port.range), plain(&port.name));
        }
        text += ");\n";
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
            text += &self.wired(printed, &body, &signals, &instances)?;
        }
        // A name that ends in a star is a family, numbered in the order of appearance.
        let named = |name: &str| Module { name: name.into(), text: text.replacen("NAME", name, 1) };
        let module = match tag.strip_suffix('*') {
            None => named(&tag),
            Some(family) => {
                let mut members = (0..).map(|i| named(&format!("{family}{i}")));
                let free = |module: &Module| self.modules.contains(module) || !self.origins.contains_key(&module.name);
                members.find(free).unwrap_or_else(|| named(family))
            }
        };
        let name = module.name.clone();
        match self.origins.get(&name) {
            None => {
                self.origins.insert(name.clone(), printed.into());
                self.modules.push(module);
            }
            Some(_) if self.modules.contains(&module) => {}
            Some(first) => {
                return Err(EmissionError::Ambiguous { name, first: first.clone(), second: printed.into() });
            }
        }
        self.names.insert(printed.into(), name);
        Ok(())
    }

    /// The body of a module that only wires: assignments and instances.
    fn wired(
        &self,
        printed: &str,
        body: &[&str],
        signals: &[Declaration],
        instances: &[Instance],
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
            let mut text = format!("{} {} (\n", self.names[&instance.module], plain(&instance.name));
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
}
