//! The feature record: the output of the hardware for one feature, and its words.

use hoverlock_reference::features::feature::{Descriptor, Feature, MAX_PAIRS};
use hoverlock_registers::record::{
    FLAG_BRIGHT, FLAG_SCALE, FLAG_THIRD, RECORD_WORDS, RecordField, TWO_PAIR_WORDS, feature,
};

/// The feature record of the hardware: 256 bits in eight 32-bit words, or 320 bits in ten where the design has three
/// scale pairs. The first eight words have the same layout in both; the words of a pair that the design does not have
/// are 0.
///
/// | word | bits 31..16 | bits 15..0 |
/// |---|---|---|
/// | 0 | `y` | `x` |
/// | 1 | flags | response |
/// | 2 | right neighbour | left neighbour |
/// | 3 | lower neighbour | upper neighbour |
/// | 4, 5 | MaxLBP k0, MaxLBP k1 | |
/// | 6, 7 | sign k0, sign k1 | |
/// | 8, 9 | MaxLBP k2, sign k2: records of ten words only | |
///
/// Flags: bits 0 and 2 the scale pair, bit 0 the lower, bit 1 the polarity (1 where `d_k >= 0`, a bright spot), bit 15
/// set in the trailer record of a frame and never in a feature. Bit 12 of the trailer says that the records have ten
/// words. The other bits are 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FeatureRecord {
    /// Column of the pixel, px.
    pub x: u16,
    /// Row of the pixel, px.
    pub y: u16,
    /// `DOG_k` at the pixel, LSB of the DoG.
    pub response: u16,
    /// Scale pair, 0 to 2.
    pub scale: u8,
    /// Polarity: `d_k >= 0`.
    pub bright: bool,
    /// `DOG_k` at the left, right, upper and lower neighbour.
    pub neighbours: [u16; 4],
    /// Descriptor of all scales.
    pub descriptor: Descriptor,
}

/// Descriptor words of the scale pairs.
const MAXLBP: [RecordField; MAX_PAIRS] = [feature::MAXLBP_0, feature::MAXLBP_1, feature::MAXLBP_2];
const SIGN: [RecordField; MAX_PAIRS] = [feature::SIGN_0, feature::SIGN_1, feature::SIGN_2];

impl FeatureRecord {
    /// Returns the record as 32-bit words, least significant word first. A design of one or two scale pairs sends the
    /// first [`TWO_PAIR_WORDS`]; the others are 0.
    pub fn pack(&self) -> [u32; RECORD_WORDS] {
        let scale = [0, FLAG_SCALE, FLAG_THIRD][usize::from(self.scale)];
        let flags = scale | if self.bright { FLAG_BRIGHT } else { 0 };
        let [left, right, upper, lower] = self.neighbours;
        let mut words = [0; RECORD_WORDS];
        let halves = [
            (feature::X, self.x),
            (feature::Y, self.y),
            (feature::RESPONSE, self.response),
            (feature::FLAGS, flags),
            (feature::LEFT, left),
            (feature::RIGHT, right),
            (feature::UPPER, upper),
            (feature::LOWER, lower),
        ];
        for (field, value) in halves {
            field.put(&mut words, value.into());
        }
        let Descriptor { maxlbp, sign } = &self.descriptor;
        for k in 0..MAX_PAIRS {
            MAXLBP[k].put(&mut words, maxlbp[k]);
            SIGN[k].put(&mut words, sign[k]);
        }
        words
    }

    /// Reads a record of eight or ten words. Returns `None` if a flag is set that no feature has, or for another number
    /// of words.
    pub fn unpack(words: &[u32]) -> Option<Self> {
        let has_third = match words.len() {
            TWO_PAIR_WORDS => false,
            RECORD_WORDS => true,
            _ => return None,
        };
        let half = |field: RecordField| field.get(words) as u16;
        let flags = half(feature::FLAGS);
        let scale = match flags & (FLAG_SCALE | FLAG_THIRD) {
            0 => 0,
            FLAG_SCALE => 1,
            FLAG_THIRD if has_third => 2,
            _ => return None,
        };
        let of_pairs = |fields: [RecordField; MAX_PAIRS]| {
            fields.map(|field| if field.word < words.len() { field.get(words) } else { 0 })
        };
        (flags & !(FLAG_SCALE | FLAG_THIRD | FLAG_BRIGHT) == 0).then(|| Self {
            x: half(feature::X),
            y: half(feature::Y),
            response: half(feature::RESPONSE),
            scale,
            bright: flags & FLAG_BRIGHT != 0,
            neighbours: [half(feature::LEFT), half(feature::RIGHT), half(feature::UPPER), half(feature::LOWER)],
            descriptor: Descriptor { maxlbp: of_pairs(MAXLBP), sign: of_pairs(SIGN) },
        })
    }

    /// Converts the record to a feature in DN of the camera sample. `dog_lsb` is the LSB of the DoG, DN.
    pub fn feature(&self, dog_lsb: f64) -> Feature {
        Feature {
            x: u32::from(self.x),
            y: u32::from(self.y),
            scale: self.scale,
            bright: self.bright,
            response: f64::from(self.response) * dog_lsb,
            neighbours: self.neighbours.map(|response| f64::from(response) * dog_lsb),
            descriptor: self.descriptor,
        }
    }
}

impl From<&FeatureRecord> for Feature {
    /// Converts a record of the default design, whose LSB of the DoG is 0.5 DN.
    fn from(record: &FeatureRecord) -> Self {
        record.feature(0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_registers::record::FLAG_TRAILER;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn unpacking_restores_a_packed_record(
            (x, y, response, scale, bright) in (any::<u16>(), any::<u16>(), any::<u16>(), 0u8..3, any::<bool>()),
            neighbours: [u16; 4], maxlbp: [u32; 3], sign: [u32; 3],
        ) {
            let record =
                FeatureRecord { x, y, response, scale, bright, neighbours, descriptor: Descriptor { maxlbp, sign } };
            let words = record.pack();
            prop_assert_eq!(FeatureRecord::unpack(&words), Some(record));
            let two_pairs = Descriptor { maxlbp: [maxlbp[0], maxlbp[1], 0], sign: [sign[0], sign[1], 0] };
            let short = (scale < 2).then_some(FeatureRecord { descriptor: two_pairs, ..record });
            prop_assert_eq!(FeatureRecord::unpack(&words[..TWO_PAIR_WORDS]), short);
            prop_assert_eq!(FeatureRecord::unpack(&words[..9]), None);
        }
    }

    #[test]
    fn records_have_the_documented_layout() {
        let descriptor = Descriptor {
            maxlbp: [0x0102_0304, 0x1112_1314, 0x4142_4344],
            sign: [0x2122_2324, 0x3132_3334, 0x5152_5354],
        };
        let record = FeatureRecord {
            x: 0x0a0b,
            y: 0x0c0d,
            response: 0x7abc,
            scale: 1,
            bright: true,
            neighbours: [0x1111, 0x2222, 0x3333, 0x4444],
            descriptor,
        };
        let words = record.pack();
        assert_eq!(words[..4], [0x0c0d_0a0b, 0x0003_7abc, 0x2222_1111, 0x4444_3333]);
        assert_eq!(words[4..8], [0x0102_0304, 0x1112_1314, 0x2122_2324, 0x3132_3334]);
        assert_eq!(words[8..], [0x4142_4344, 0x5152_5354]);
        assert_eq!(FeatureRecord { scale: 2, ..record }.pack()[1], 0x0006_7abc);
        let mut trailer = words;
        trailer[1] |= u32::from(FLAG_TRAILER) << 16;
        assert_eq!(FeatureRecord::unpack(&trailer), None);
        let feature = Feature::from(&record);
        assert_eq!((feature.x, feature.response), (0x0a0b, f64::from(0x7abc) / 2.0));
    }
}
