//! The level `rtl` of a report: simulation of the pictures by the emitted Verilog, and the Yosys estimate.
//!
//! With an empty cache, building the model and running Yosys take a minute or two, so both run in parallel with the
//! rest of the study. If a tool is missing or fails, the report gives the reason and has no results of this level.

use std::thread::{JoinHandle, spawn};

use anyhow::{Result, anyhow};
use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::analysis::acceptance::dog_lsb;
use hoverlock_fixed_point::analysis::levels::raw_thresholds;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_reports::hardware::{
    DeviceUtilisation, Hardware, ModuleResources, ResourceEstimate, Simulated, StepResult,
};
use hoverlock_reports::study::{self, Study, Subject};
use hoverlock_simulation::{Job, Outcome, Simulator, Streams, Trace, run};
use hoverlock_synthesis::{Estimate, estimate};

use crate::message;
use crate::progress::spinning;

/// Number of modules that the page lists.
const LISTED_MODULES: usize = 12;

/// A background thread that builds the Verilated model and runs the Yosys estimate; see [`prepare`].
pub struct Preparation(JoinHandle<Tools>);

/// The model and the estimate, or the reasons why they are missing.
struct Tools {
    simulator: StepResult<Simulator>,
    estimate: StepResult<ResourceEstimate>,
}

/// Begins to build the model and to run Yosys.
pub fn prepare(design: &DesignPoint) -> Preparation {
    let design = design.clone();
    Preparation(spawn(move || {
        let simulator = match Simulator::of_design(&design, None, Trace::None) {
            Ok(simulator) => StepResult::Run { result: simulator },
            Err(error) => StepResult::not_run(message(&error.into())),
        };
        let estimate = match estimate(&design, None, &mut |_| ()) {
            Ok(estimate) => StepResult::Run { result: resource_estimate(estimate) },
            Err(error) => StepResult::not_run(message(&error.into())),
        };
        Tools { simulator, estimate }
    }))
}

impl Preparation {
    /// Simulates every picture and adds the results to the study.
    pub fn finish(self, study: Study, subjects: &[Subject], step: &dyn Fn(&str)) -> Result<Study> {
        step("waiting for Verilator and Yosys");
        let name = "building the Verilated model and running Yosys for this design (once; later runs find both)";
        let tools = spinning(name, || self.0.join()).map_err(|_| anyhow!("the model's builder has panicked"))?;
        let simulation = match &tools.simulator {
            StepResult::NotRun { reason } => StepResult::not_run(reason.clone()),
            StepResult::Run { result: simulator } => {
                let mut runs = Vec::new();
                for subject in subjects {
                    step(&format!("{}, rtl", subject.name));
                    runs.push(simulate(simulator, &study, subject)?);
                }
                StepResult::Run { result: runs }
            }
        };
        Ok(study.with_hardware(Hardware { simulation, estimate: tools.estimate }))
    }
}

/// Simulates the conditions of a picture as frames back to back, each with the thresholds at which its other levels
/// were compared.
fn simulate(simulator: &Simulator, study: &Study, subject: &Subject) -> Result<Simulated> {
    let measured = study.pictures.iter().find(|picture| picture.name == subject.name);
    let conditions = measured.map(|picture| picture.conditions.as_slice()).unwrap_or_default();
    let design = simulator.design();
    let jobs = study::frames(subject)
        .into_iter()
        .zip(conditions)
        .map(|(frame, condition)| {
            // The study's LSB is that of the default design.
            let scales = condition.comparison.scales.iter();
            let thresholds: Vec<f64> = scales.map(|scale| scale.threshold_lsb * dog_lsb()).collect();
            Ok(Job::of(design, camera_samples(design, &frame), raw_thresholds(design, &thresholds))?)
        })
        .collect::<Result<Vec<_>>>()?;
    let outcome = run(simulator, &jobs, Streams::default())?;
    Ok(simulated(&subject.name, jobs.len(), outcome))
}

fn simulated(picture: &str, frames: usize, outcome: Outcome) -> Simulated {
    let complete = outcome.pass();
    let first_mismatch = outcome.first_mismatch.map(|first| {
        format!(
            "{}, frame {}, x {}, y {}, cycle {}: {} expected {}, actual {}",
            first.stage, first.frame, first.x, first.y, first.cycle, first.field, first.expected, first.actual
        )
    });
    Simulated {
        picture: picture.into(),
        frames: frames as u64,
        pixels: outcome.pixels,
        cycles: outcome.cycles,
        samples: outcome.samples,
        features: outcome.features,
        dropped: outcome.dropped,
        mismatches: outcome.mismatches,
        first_mismatch,
        complete,
        cycles_per_pixel: outcome.cycles_per_pixel,
        latency_lines: outcome.latency_lines,
        feature_latency_lines: outcome.feature_latency_lines,
    }
}

fn resource_estimate(estimate: Estimate) -> ResourceEstimate {
    let device = |device: hoverlock_synthesis::Device| DeviceUtilisation {
        name: device.name,
        source: device.source.into(),
        has: [device.alm, device.m10k, device.dsp],
        limits: device.limits,
        used_percent: device.used_percent,
        fits: device.fits,
    };
    let modules = estimate.modules.iter().take(LISTED_MODULES).map(|module| ModuleResources {
        name: module.name.clone(),
        instances: module.instances,
        alm: module.alm,
        m10k: module.m10k,
        mul18: module.mul18,
        registers: module.registers,
        logic_levels: module.logic_levels,
    });
    ResourceEstimate {
        modules: modules.collect(),
        label: estimate.label.into(),
        alm: estimate.alm,
        m10k: estimate.m10k,
        dsp: estimate.dsp,
        mul18: estimate.mul18,
        registers: estimate.registers,
        logic_levels: estimate.logic_levels,
        target_mhz: estimate.target_mhz,
        alm_rule: estimate.alm_rule.into(),
        levels_rule: estimate.levels_rule.into(),
        fits_rule: estimate.fits_rule.into(),
        devices: estimate.devices.into_iter().map(device).collect(),
    }
}
