//! Turns `map.toml` into the constants that `src/layout.rs` and `src/record.rs` include.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fmt::Write;
use std::path::PathBuf;

use serde::Deserialize;

/// Bits of a register and of a word of a record.
const WORD_BITS: u32 = 32;

/// Most coefficients of a design: four smoothers of look-ahead 6.
const MAX_COEFFICIENTS: u32 = 4 * 7;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Map {
    version: Version,
    register: Vec<Register>,
    coefficients: Coefficients,
    record: Record,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Version {
    two_pairs: u32,
    three_pairs: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Register {
    name: String,
    offset: u32,
    fields: Vec<Field>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Field {
    name: String,
    low: u32,
    bits: Number,
    access: String,
    #[serde(default)]
    reset: Number,
    scale_pair: Option<usize>,
    #[serde(default)]
    protection: bool,
    description: String,
}

/// A number, or the name of a parameter of the design.
#[derive(Deserialize)]
#[serde(untagged)]
enum Number {
    Constant(u32),
    Parameter(String),
}

impl Default for Number {
    fn default() -> Self {
        Self::Constant(0)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Coefficients {
    offset: u32,
    recursion: Coefficient,
    look_ahead: Coefficient,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Coefficient {
    name: String,
    description: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    two_pair_words: usize,
    three_pair_words: usize,
    flag: Vec<Flag>,
    error: Vec<Flag>,
    feature: BTreeMap<String, RecordField>,
    trailer: BTreeMap<String, RecordField>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Flag {
    name: String,
    bit: u32,
    description: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RecordField {
    word: usize,
    low: u32,
    bits: u32,
    description: String,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=map.toml");
    let map: Map = toml::from_str(&std::fs::read_to_string("map.toml")?)?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("layout.rs"), layout(&map)?)?;
    std::fs::write(out.join("record.rs"), record(&map.record)?)?;
    Ok(())
}

/// Returns the Rust of the registers.
fn layout(map: &Map) -> Result<String, Box<dyn Error>> {
    let Version { two_pairs, three_pairs } = map.version;
    let mut text = format!(
        "pub(crate) const TWO_PAIR_VERSION: u32 = {two_pairs:#010x};\n\
         pub(crate) const THREE_PAIR_VERSION: u32 = {three_pairs:#010x};\n\
         pub(crate) const REGISTERS: &[RegisterLayout] = &[\n"
    );
    let (mut next, mut names) = (0, BTreeSet::new());
    for register in &map.register {
        let Register { name, offset, fields } = register;
        let coefficients = map.coefficients.offset..map.coefficients.offset + 4 * MAX_COEFFICIENTS;
        if *offset < next || !offset.is_multiple_of(4) || coefficients.contains(offset) || !names.insert(name) {
            return Err(format!("register {name}: offset {offset:#x} or the name is used, or out of order").into());
        }
        next = offset + 4;
        writeln!(text, "RegisterLayout {{ name: {name:?}, offset: {offset:#x}, fields: &[")?;
        let mut free = 0;
        for field in fields {
            if field.low < free || field.low >= WORD_BITS {
                return Err(format!("register {name}: field {} overlaps another or is out of order", field.name).into());
            }
            // How many bits a parameter takes is known with the design.
            free = field.low + if let Number::Constant(bits) = field.bits { bits } else { 1 };
            writeln!(
                text,
                "    FieldLayout {{ name: {:?}, low: {}, bits: {}, access: Access::{}, reset: {}, scale_pair: {:?}, \
                 protection: {}, description: {:?} }},",
                field.name,
                field.low,
                number(&field.bits),
                camel_case(&field.access),
                number(&field.reset),
                field.scale_pair,
                field.protection,
                field.description
            )?;
        }
        text += "] },\n";
    }
    let Coefficients { offset, recursion, look_ahead } = &map.coefficients;
    writeln!(text, "];\n/// Byte offset of the first coefficient.\npub const COEFFICIENTS_OFFSET: u32 = {offset:#x};")?;
    for (name, Coefficient { name: pattern, description }) in [("RECURSION", recursion), ("LOOK_AHEAD", look_ahead)] {
        writeln!(
            text,
            "pub(crate) const {name}: CoefficientLayout = CoefficientLayout {{ name: {pattern:?}, description: \
             {description:?} }};"
        )?;
    }
    Ok(text)
}

/// Returns the Rust of the records.
fn record(record: &Record) -> Result<String, Box<dyn Error>> {
    let Record { two_pair_words, three_pair_words, flag, error, feature, trailer } = record;
    let mut text = format!(
        "/// Words of a record of one or two scale pairs.\npub const TWO_PAIR_WORDS: usize = {two_pair_words};\n\
         /// Words of a record of three scale pairs, the longest there is.\n\
         pub const RECORD_WORDS: usize = {three_pair_words};\n"
    );
    for (prefix, bits) in [("FLAG", flag), ("ERROR", error)] {
        for Flag { name, bit, description } in bits {
            let name = name.to_uppercase();
            writeln!(text, "/// {description}\npub const {prefix}_{name}: u16 = 1 << {bit};")?;
        }
    }
    for (module, what, fields) in [("feature", "a feature", feature), ("trailer", "a trailer", trailer)] {
        writeln!(text, "/// Fields of {what}.\npub mod {module} {{\n    use super::RecordField;")?;
        let mut used = BTreeSet::new();
        for (name, RecordField { word, low, bits, description }) in fields {
            let is_free = (*low..low + bits).all(|bit| used.insert((word, bit)));
            if !is_free || word >= three_pair_words || low + bits > WORD_BITS {
                return Err(format!("record.{module}: {name} overlaps another field or leaves its word").into());
            }
            writeln!(
                text,
                "    /// {description}\n    pub const {}: RecordField = RecordField {{ word: {word}, low: {low}, bits: \
                 {bits} }};",
                name.to_uppercase()
            )?;
        }
        text += "}\n";
    }
    Ok(text)
}

fn number(number: &Number) -> String {
    match number {
        Number::Constant(value) => format!("Number::Constant({value})"),
        Number::Parameter(name) => format!("Number::Of(Parameter::{})", camel_case(name)),
    }
}

fn camel_case(name: &str) -> String {
    name.split('_').map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}
