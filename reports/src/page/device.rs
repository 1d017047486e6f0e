//! The plot of device utilisation: ALM, M10K and DSP blocks of the target device.

use super::numbers::grouped;
use crate::colour::Rgb;
use crate::hardware::{DeviceUtilisation, ResourceEstimate};
use crate::plot::{Axis, BLUE, Chart, Mark, PlotError, Series};

/// Plots the utilisation of the first device: used, in front of the limit and of what the device has. Empty without a
/// device.
pub(super) fn plot(estimate: &ResourceEstimate) -> Result<String, PlotError> {
    let Some(DeviceUtilisation { name, has, limits, used_percent, .. }) = estimate.devices.first() else {
        return Ok(String::new());
    };
    let used = [estimate.alm, estimate.m10k, estimate.dsp];
    let names = ["ALM", "M10K blocks", "DSP blocks"];
    let ticks = (0..3).map(|i| {
        (i as f64, format!("{}: {} of {}, limit {}", names[i], grouped(used[i]), grouped(has[i]), grouped(limits[i])))
    });
    let bars = |name: &str, colour: Rgb, width: f64, height: &dyn Fn(usize) -> f64| Series {
        name: name.into(),
        colour,
        mark: Mark::Bars(width),
        points: (0..3).map(|i| (i as f64, height(i))).collect(),
    };
    Chart {
        title: format!("{name}: utilisation, Yosys estimate"),
        size: (1040, 280),
        x: Axis::ticked("", -0.5, 2.5, ticks.collect()),
        y: Axis::linear("% of the device", 0.0, 100.0),
        series: vec![
            bars("device", [228, 232, 236], 0.5, &|_| 100.0),
            bars("limit", [176, 190, 204], 0.5, &|i| 100.0 * limits[i] as f64 / has[i] as f64),
            bars("used", BLUE, 0.3, &|i| used_percent[i]),
        ],
        rules: Vec::new(),
    }
    .svg()
}
