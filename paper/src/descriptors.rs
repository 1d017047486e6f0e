//! Figures 8 and 9: LBP on intensities and MaxLBP on responses.

use std::fmt::Write as _;

use hoverlock_pictures::conditions::FOG;
use hoverlock_reference::features::dog::SIGMAS;
use hoverlock_reference::features::extractor::{features, layers};
use hoverlock_reference::features::feature::{Descriptor, Feature};
use hoverlock_reference::features::maxima::spread;
use hoverlock_reference::features::maxlbp::{Layer, MAX_RADIUS, Ring};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::smoother::Smoother;
use hoverlock_reports::figures::background;
use hoverlock_reports::repeatability::lbp;

use crate::motion::{Pairing, SELECTION, views_of};
use crate::scenes::{Photograph, files, png};
use crate::{Item, PaperError};

/// Half the side of the drawn part of a frame, px.
const REACH: usize = 22;
/// Side of a pixel in the drawing.
const ZOOM: usize = 10;

/// The features of a frame, with each kind of descriptor.
struct Described {
    layers: Vec<Layer<f64>>,
    maxlbp: Vec<Feature>,
    lbp: Vec<Feature>,
}

fn described(frame: &Plane<u16>) -> Result<Described, PaperError> {
    let smoothers =
        SIGMAS.iter().map(|&sigma| Smoother::first_order(sigma)).collect::<Result<Vec<_>, DesignError>>()?;
    let smooth = |plane: &Plane<f64>, sigma: f64| {
        let own = smoothers.iter().find(|smoother| smoother.sigma() == sigma);
        own.map_or_else(|| plane.clone(), |smoother| smoother.smooth(plane, Border::Held))
    };
    let layers = layers(frame, &SIGMAS, &Ring::defaults(), smooth);
    let all = features(&layers, &vec![SELECTION.threshold; layers.len()], 1.0);
    let maxlbp = spread(&all, SELECTION.count, |feature| (feature.x, feature.y, feature.response));
    let plain = |feature: &Feature| Feature {
        descriptor: lbp::descriptor(frame, feature.x as usize, feature.y as usize),
        ..*feature
    };
    let lbp = maxlbp.iter().map(plain).collect();
    Ok(Described { layers, maxlbp, lbp })
}

/// Draws the surroundings of a feature with the points of a ring: filled where the bit is 1. Each point has a window of
/// `2 window + 1` pixels.
fn ring(title: &str, picture: &Plane<u16>, feature: &Feature, word: u32, window: usize) -> Result<String, PaperError> {
    let (x0, y0) = (feature.x as usize - REACH, feature.y as usize - REACH);
    let side = 2 * REACH + 1;
    let crop = Plane::from_fn(side, side, |x, y| {
        picture[((x0 + x).min(picture.width() - 1), (y0 + y).min(picture.height() - 1))]
    });
    let size = side * ZOOM;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {size} {size}\" style=\"max-width:560px\" role=\"img\" aria-label=\"{title}\"><image \
         width=\"{size}\" height=\"{size}\" \
         style=\"image-rendering:pixelated\" href=\"{}\"/>",
        background(&crop)?
    );
    let middle = (REACH * ZOOM + ZOOM / 2) as f64;
    // Writing to a String cannot fail.
    let _ = write!(
        svg,
        "<circle cx=\"{middle}\" cy=\"{middle}\" r=\"7\" fill=\"none\" stroke=\"#ffcd28\" stroke-width=\"3\"/>"
    );
    for (i, &(dx, dy)) in Ring::defaults()[usize::from(feature.scale)].0.iter().enumerate() {
        let (x, y) = (middle + (dx * ZOOM as i32) as f64, middle + (dy * ZOOM as i32) as f64);
        let fill = if word >> i & 1 == 1 { "#6dff8b" } else { "none" };
        let half = (window * ZOOM + ZOOM / 2) as f64;
        let _ = write!(
            svg,
            "<rect x=\"{}\" y=\"{}\" width=\"{w}\" height=\"{w}\" fill=\"none\" stroke=\"#7fd0ff\" \
             stroke-opacity=\"0.5\"/>\
             <circle cx=\"{x}\" cy=\"{y}\" r=\"4\" fill=\"{fill}\" stroke=\"#6dff8b\" stroke-width=\"1.5\"/>",
            x - half,
            y - half,
            w = 2.0 * half
        );
    }
    Ok(svg + "</svg>")
}

/// Returns the strongest feature whose surroundings are inside the frame.
fn strongest<'a>(found: &'a [Feature], frame: &Plane<u16>) -> Option<&'a Feature> {
    let inside = |at: u32, size: usize| (REACH..size - REACH).contains(&(at as usize));
    let candidates = found.iter().filter(|f| inside(f.x, frame.width()) && inside(f.y, frame.height()));
    candidates.max_by(|a, b| a.response.total_cmp(&b.response))
}

/// Figures 8 and 9.
pub fn items() -> Result<Vec<Item>, PaperError> {
    let views = views_of("field")?;
    let [reference, current] = [described(&views[0].frame)?, described(&views[1].frame)?];
    let fog = FOG.apply(&views[1].frame, 1);
    let in_fog = described(&fog)?;
    let pairings = |views: &[Photograph; 2], other: &Described| {
        let of = |features: [&Vec<Feature>; 2], strict: bool| Pairing::of(views, &features.map(Clone::clone), strict);
        [
            of([&reference.lbp, &other.lbp], true),
            of([&reference.maxlbp, &other.maxlbp], true),
            of([&reference.maxlbp, &other.maxlbp], false),
        ]
    };
    let (clear, foggy) = (pairings(&views, &current), pairings(&views, &in_fog));
    let told = |[lbp, strict, signed]: &[Pairing; 3]| {
        format!(
            "LBP {} ({:.0} %), MaxLBP {} ({:.0} %), MaxLBP with signs {} ({:.0} %); of the matches of a \
             second search near the motion found {}, {} and {} agree",
            lbp.correct,
            lbp.percent(),
            strict.correct,
            strict.percent(),
            signed.correct,
            signed.percent(),
            lbp.agree,
            strict.agree,
            signed.agree
        )
    };
    let example = strongest(&reference.maxlbp, &views[0].frame);
    let mut drawings = [Vec::new(), Vec::new()];
    if let Some(feature) = example {
        let k = usize::from(feature.scale);
        let dog = &reference.layers[k].dog.magnitude;
        let peak = dog.as_slice().iter().copied().fold(1.0, f64::max);
        let responses = dog.map(|&dn| (65535.0 * dn / peak) as u16);
        let own: Descriptor = lbp::descriptor(&views[0].frame, feature.x as usize, feature.y as usize);
        drawings[0].push(ring("LBP of the strongest feature", &views[0].frame, feature, own.maxlbp[k], 0)?);
        drawings[1].push(ring(
            "MaxLBP of the strongest feature",
            &responses,
            feature,
            feature.descriptor.maxlbp[k],
            MAX_RADIUS,
        )?);
        drawings[1].push(ring(
            "signs around the strongest feature",
            &responses,
            feature,
            feature.descriptor.sign[k],
            0,
        )?);
    }
    let [of_lbp, of_maxlbp] = drawings;
    let mut commands = Vec::new();
    for ([_, strict, signed], second) in [(&clear, "field_2.png"), (&foggy, "field_2_fog.png")] {
        for (pairing, words) in [(strict, "strict"), (signed, "full")] {
            let line = format!("hoverlock match field_1.png {second} --level recursive --descriptor {words}");
            commands.push(pairing.command(line));
        }
    }
    let mut inputs = files("field", &views)?;
    inputs.push(("field_2_fog.png".into(), png(&fog)?));
    Ok(vec![
        Item {
            number: "figure 8",
            title: "LBP: a bit for each point of a ring that is brighter than the centre",
            stated: "Local binary patterns describe the surroundings of a point by comparisons.",
            found: "The strongest feature of the field on its frame; filled points are 1.".into(),
            holds: None,
            only_here: "the bits of the drawing. hoverlock report PICTURE compares LBP with MaxLBP under warps of \
                        the picture",
            drawings: of_lbp,
            ..Item::default()
        },
        Item {
            number: "figure 9",
            title: "MaxLBP: the response against the largest one around each point",
            stated: "MaxLBP is more robust than LBP.",
            found: format!(
                "The same feature on its responses: left MaxLBP, right the signs, which were added here because nine \
                 of ten bits of MaxLBP are \
                 1 at a maximum. Correct matches between two views of the field: {}. The second view in fog: {}.",
                told(&clear),
                told(&foggy)
            ),
            holds: Some(clear[1].correct > clear[0].correct && foggy[1].correct > foggy[0].correct),
            commands,
            only_here: "the numbers of LBP, which is in no other command, and of correct matches, which take the true \
                        motion",
            inputs,
            drawings: of_maxlbp,
            ..Item::default()
        },
    ])
}
