use super::*;
use crate::features::feature::Descriptor;
use proptest::prelude::*;

/// Returns a feature. The words are in the order of the record; missing ones are 0.
fn feature<const N: usize>(position: (u32, u32), group: (u8, bool), response: f64, words: [u32; N]) -> Feature {
    let word = |i: usize| words.get(i).copied().unwrap_or_default();
    Feature {
        x: position.0,
        y: position.1,
        scale: group.0,
        bright: group.1,
        response,
        neighbours: [0.0; 4],
        descriptor: Descriptor { maxlbp: [word(0), word(1), word(4)], sign: [word(2), word(3), word(5)] },
    }
}

/// Few bits and few responses, so that ties abound.
fn features() -> impl Strategy<Value = Vec<Feature>> {
    let one = ((0..1024u32, 0..768u32), (0..3u8, any::<bool>()), 1..6u32, prop::array::uniform6(0..8u32))
        .prop_map(|(position, group, halves, words)| feature(position, group, f64::from(halves) / 2.0, words));
    (prop::collection::vec(one, 0..60), any::<bool>()).prop_map(|(mut features, three_pairs)| {
        if !three_pairs {
            features.iter_mut().for_each(|f| (f.descriptor.maxlbp[2], f.descriptor.sign[2]) = (0, 0));
        }
        features
    })
}

fn settings() -> impl Strategy<Value = Matching> {
    let distance = prop_oneof![Just(Distance::Lexicographic), (0.0..2.0f64).prop_map(Distance::Sum)];
    let gate = prop::option::of((-300..300i32, -300..300i32, 1.0..400.0f64));
    (distance, any::<bool>(), gate, prop::option::of(0.3..1.0f64), prop::option::of(0.0..9.0f64)).prop_map(
        |(distance, strict, gate, ratio, limit)| Matching {
            distance,
            strict,
            gate: gate.map(|(x, y, radius)| Gate { prediction: shift(x, y), radius }),
            ratio,
            limit,
        },
    )
}

fn shift(x: i32, y: i32) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, f64::from(x), 0.0, 1.0, f64::from(y), 0.0, 0.0, 1.0)
}

/// Matches by the definition, without the optimisations.
fn by_definition(settings: &Matching, reference: &[Feature], current: &[Feature]) -> Vec<(usize, usize)> {
    let key = |a: &Feature, b: &Feature| -> Option<(f64, f64)> {
        let allowed = a.scale == b.scale
            && a.bright == b.bright
            && settings.gate.is_none_or(|gate| {
                let (ax, ay) = a.subpixel();
                let (bx, by) = b.subpixel();
                let expected = transfer(&gate.prediction, Vector2::new(ax, ay)).unwrap();
                (Vector2::new(bx, by) - expected).norm_squared() <= gate.radius * gate.radius
            });
        let difference = (a.response - b.response).abs();
        let hamming = f64::from(a.descriptor.hamming(&b.descriptor, settings.strict));
        let distance = match settings.distance {
            Distance::Lexicographic => hamming,
            Distance::Sum(c) => hamming + c * difference.powi(2),
        };
        allowed.then_some((distance, difference))
    };
    // Ordered partners of one feature: (distance, difference, index).
    let ranked = |keys: Vec<Option<(f64, f64)>>| -> Vec<(f64, f64, usize)> {
        let mut ranked: Vec<_> = keys.iter().enumerate().filter_map(|(i, k)| k.map(|(d, r)| (d, r, i))).collect();
        ranked.sort_by(|a, b| a.partial_cmp(b).unwrap());
        ranked
    };
    let mut found = Vec::new();
    for (i, a) in reference.iter().enumerate() {
        let forward = ranked(current.iter().map(|b| key(a, b)).collect());
        let Some(&(distance, _, j)) = forward.first() else { continue };
        let backward = ranked(reference.iter().map(|a| key(a, &current[j])).collect());
        let distinct =
            |list: &[(f64, f64, usize)], ratio: f64| list.get(1).is_none_or(|second| distance <= ratio * second.0);
        if backward[0].2 == i
            && settings.ratio.is_none_or(|ratio| distinct(&forward, ratio) && distinct(&backward, ratio))
            && settings.limit.is_none_or(|limit| distance <= limit)
        {
            found.push((i, j));
        }
    }
    found
}

proptest! {
    #[test]
    fn matches_are_those_of_the_definition(a in features(), b in features(), settings in settings()) {
        let matches = settings.matches(&a, &b);
        let mut found: Vec<_> = matches.iter().map(|m| (m.reference, m.current)).collect();
        prop_assert!(matches.is_sorted_by(|a, b| a.best_first(b) == Ordering::Less));
        found.sort_unstable();
        prop_assert_eq!(found, by_definition(&settings, &a, &b));
    }

    #[test]
    fn exchanging_the_pictures_exchanges_the_roles(a in features(), b in features(), settings in settings()) {
        let back = Matching {
            gate: settings.gate.map(|g| Gate { prediction: g.prediction.try_inverse().unwrap(), ..g }),
            ..settings
        };
        let mut forth: Vec<_> = settings.matches(&a, &b).iter().map(|m| (m.reference, m.current)).collect();
        let mut back: Vec<_> = back.matches(&b, &a).iter().map(|m| (m.current, m.reference)).collect();
        forth.sort_unstable();
        back.sort_unstable();
        prop_assert_eq!(forth, back);
    }
}

#[test]
fn responses_decide_only_between_equals() {
    let a = [feature((0, 0), (0, true), 10.0, [0b1, 0, 0, 0])];
    let near_bits = feature((0, 0), (0, true), 1000.0, [0b1, 0, 0, 0]);
    let near_response = feature((0, 0), (0, true), 10.0, [0b11, 0, 0, 0]);
    let b = [near_response, near_bits];
    assert_eq!(Matching::default().matches(&a, &b)[0].current, 1);
    // 0 + C 990^2 against 1 + C 0: the sum turns round at C = 990^-2.
    let turn = 1.0 / 990f64.powi(2);
    let with = |c: f64| Matching { distance: Distance::Sum(c), ..Matching::default() };
    assert_eq!(with(0.99 * turn).matches(&a, &b)[0].current, 1);
    assert_eq!(with(1.01 * turn).matches(&a, &b)[0].current, 0);
}

#[test]
fn scale_and_polarity_must_agree() {
    let a = [feature((0, 0), (0, true), 10.0, [5; 4])];
    for other in [(0, false), (1, true), (1, false)] {
        assert_eq!(Matching::default().matches(&a, &[feature((0, 0), other, 10.0, [5; 4])]), []);
    }
}

#[test]
fn strict_does_not_see_the_signs() {
    let a = [feature((0, 0), (0, true), 10.0, [7, 7, 0, 0])];
    let b = [feature((0, 0), (0, true), 10.0, [7, 6, u32::MAX, u32::MAX])];
    let strict = Matching { strict: true, ..Matching::default() };
    assert_eq!(strict.matches(&a, &b)[0].distance, 1.0);
    assert_eq!(Matching::default().matches(&a, &b)[0].distance, 65.0);
}
