//! The register map of a design.

use hoverlock_design::{DesignPoint, MAX_ROWS, MIN_SIDE, Protection, smoother_names};

use crate::record::default_limit;

/// What software may do with a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Read only.
    Read,
    /// Read and write.
    ReadWrite,
    /// Set by hardware, cleared by writing 1.
    Clear,
    /// Writing 1 triggers an action; reads 0.
    Pulse,
    /// Set by writing 1, cleared by hardware.
    Request,
}

/// A field of a register.
#[derive(Debug, Clone)]
pub struct Field {
    /// Name, lower case.
    pub name: String,
    /// Lowest bit.
    pub low: u32,
    /// Number of bits.
    pub bits: u32,
    /// What software may do.
    pub access: Access,
    /// Value after reset, with the lowest bit of the field at bit 0.
    pub reset: u32,
    /// Scale pair that the field belongs to, from 0; `None` if it belongs to no single one.
    pub scale_pair: Option<usize>,
    /// Meaning, for the generated headers and tables.
    pub description: String,
}

impl Field {
    /// Returns the bits of the field in its register.
    pub fn mask(&self) -> u32 {
        (((1u64 << self.bits) - 1) << self.low) as u32
    }
}

/// A register.
#[derive(Debug, Clone)]
pub struct Register {
    /// Name, lower case.
    pub name: String,
    /// Byte offset.
    pub offset: u32,
    /// Its fields, the lowest first.
    pub fields: Vec<Field>,
}

impl Register {
    /// Returns `true` for the register of a coefficient.
    pub fn is_coefficient(&self) -> bool {
        self.fields[0].name == "value"
    }

    /// Returns the value after reset.
    pub fn reset(&self) -> u32 {
        self.fields.iter().fold(0, |value, field| value | field.reset << field.low)
    }
}

/// A register as `map.toml` describes it for all designs.
pub(crate) struct RegisterLayout {
    name: &'static str,
    offset: u32,
    fields: &'static [FieldLayout],
}

/// A field as `map.toml` describes it for all designs.
pub(crate) struct FieldLayout {
    name: &'static str,
    low: u32,
    bits: Number,
    access: Access,
    reset: Number,
    scale_pair: Option<usize>,
    /// The field exists only if the memories of the design are protected.
    protection: bool,
    description: &'static str,
}

/// Patterns of name and description of a coefficient's register.
pub(crate) struct CoefficientLayout {
    name: &'static str,
    description: &'static str,
}

/// A number of the map.
#[derive(Clone, Copy)]
enum Number {
    Constant(u32),
    Of(Parameter),
}

/// A parameter of the design that numbers of the map may be.
#[derive(Clone, Copy)]
enum Parameter {
    Version,
    Width,
    Height,
    WidthBits,
    HeightBits,
    DogBits,
    InitialThreshold,
    Target,
    RecordLimit,
}

include!(concat!(env!("OUT_DIR"), "/layout.rs"));

impl Number {
    fn of(self, design: &DesignPoint) -> u32 {
        // The largest width and height are numbers of the range, not places in it.
        let bits = |max: u32| max.next_power_of_two().trailing_zeros() + 1;
        match self {
            Self::Constant(value) => value,
            Self::Of(Parameter::Version) => {
                if design.pairs() > 2 {
                    THREE_PAIR_VERSION
                } else {
                    TWO_PAIR_VERSION
                }
            }
            Self::Of(Parameter::Width) => design.width,
            Self::Of(Parameter::Height) => design.height,
            Self::Of(Parameter::WidthBits) => bits(design.width),
            Self::Of(Parameter::HeightBits) => bits(MAX_ROWS),
            Self::Of(Parameter::DogBits) => design.dog_bits,
            Self::Of(Parameter::InitialThreshold) => design.threshold.initial,
            Self::Of(Parameter::Target) => design.threshold.target,
            Self::Of(Parameter::RecordLimit) => default_limit(design.pairs()),
        }
    }
}

impl FieldLayout {
    fn of(&self, design: &DesignPoint) -> Field {
        Field {
            name: self.name.into(),
            low: self.low,
            bits: self.bits.of(design),
            access: self.access,
            reset: self.reset.of(design),
            scale_pair: self.scale_pair,
            description: self
                .description
                .replace("{min_side}", &MIN_SIDE.to_string())
                .replace("{max_width}", &design.width.to_string())
                .replace("{max_height}", &MAX_ROWS.to_string())
                .replace("{dog_lsb}", &design.dog().lsb().to_string()),
        }
    }
}

/// Returns all registers of a design in the order of their offsets. `coefficients` are the reset values of the
/// coefficients: smoother by smoother from the narrowest, the recursion first, then the stages of the look-ahead.
pub fn registers(design: &DesignPoint, coefficients: &[u32]) -> Vec<Register> {
    let is_protected = design.protection != Protection::Off;
    let exists = |field: &&FieldLayout| {
        field.scale_pair.is_none_or(|k| k < design.pairs()) && (is_protected || !field.protection)
    };
    let fixed = REGISTERS.iter().map(|layout| Register {
        name: layout.name.into(),
        offset: layout.offset,
        fields: layout.fields.iter().filter(exists).map(|field| field.of(design)).collect(),
    });
    let mut map: Vec<Register> = fixed.filter(|register| !register.fields.is_empty()).collect();
    let stages =
        smoother_names(design.smoothers()).iter().zip(&*design.look_ahead).flat_map(|(smoother, &look_ahead)| {
            std::iter::once((smoother, None)).chain((0..look_ahead).map(move |stage| (smoother, Some(stage))))
        });
    for (i, ((smoother, stage), reset)) in stages.zip(coefficients).enumerate() {
        let layout = if stage.is_none() { RECURSION } else { LOOK_AHEAD };
        let fill = |pattern: &str| {
            pattern
                .replace("{smoother}", smoother)
                .replace("{stage}", &stage.unwrap_or_default().to_string())
                .replace("{format}", &design.coefficient.to_string())
        };
        map.push(Register {
            name: fill(layout.name),
            offset: COEFFICIENTS_OFFSET + 4 * i as u32,
            fields: vec![Field {
                name: "value".into(),
                low: 0,
                bits: design.coefficient.bits(),
                access: Access::ReadWrite,
                reset: *reset,
                scale_pair: None,
                description: fill(layout.description),
            }],
        });
    }
    map.sort_by_key(|register| register.offset);
    map
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::SHIPPED;

    /// The fields of a register do not overlap in any design that comes with the project, and every placeholder of a
    /// description is known.
    #[test]
    fn fields_fit_their_registers_in_every_shipped_design() {
        for (name, _) in SHIPPED {
            let design = DesignPoint::shipped(name).unwrap().with_override("protection=parity").unwrap();
            let count = design.look_ahead.iter().map(|stages| 1 + *stages as usize).sum();
            let map = registers(&design, &vec![1; count]);
            for register in &map {
                let mut free = 0;
                for field in &register.fields {
                    assert!(field.low >= free && field.low + field.bits <= 32, "{name}: {register:?}");
                    assert!(!field.description.contains('{'), "{name}: {field:?}");
                    assert!(field.bits == 32 || field.reset >> field.bits == 0, "{name}: {field:?}");
                    free = field.low + field.bits;
                }
            }
            let coefficients = map.iter().filter(|register| register.is_coefficient());
            assert_eq!(coefficients.count(), count, "{name}");
            assert!(map.is_sorted_by_key(|register| register.offset), "{name}");
        }
    }
}
