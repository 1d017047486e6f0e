//! Runs Yosys, once for a given Verilog: its netlist is kept in the cache folder under the hash of everything that it
//! depends on.

use std::{
    collections::BTreeMap,
    fs,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use sha2::{Digest, Sha256};

use crate::{
    Estimate, EstimateError, derive,
    memory::memories,
    netlist::{Flat, Netlist},
};
use hoverlock_design::DesignPoint;
use hoverlock_rtl::emission::{
    File,
    parameters::{Variant, instances, modules},
    verilog::verilog,
};

const TOP: &str = "hoverlock_top";

/// Estimates the resources of a design from the Verilog in `folder`, or, without a folder, from the committed files of
/// the default design or the emission of another. A netlist of the same Verilog is read from the cache; otherwise
/// Yosys runs for minutes. `step` is called with the name of each step, such as a pass of Yosys.
///
/// # Errors
/// If the folder has no Verilog, Yosys is missing or fails, or its netlist is not that of the design.
pub fn estimate(
    design: &DesignPoint,
    folder: Option<&Path>,
    step: &mut dyn FnMut(&str),
) -> Result<Estimate, EstimateError> {
    let sources = verilog(design, folder)?
        .iter()
        .map(|path| {
            let text = fs::read_to_string(path).map_err(at(path))?;
            Ok(File { path: path.to_string_lossy().into_owned(), text })
        })
        .collect::<Result<Vec<_>, EstimateError>>()?;
    of(&sources, TOP, step)
}

/// Estimates the resources of the module `top` and all modules below it. The order of `sources` has no effect: Yosys's
/// result depends on the order in which it reads files, so it reads them in the order of their names.
///
/// # Errors
/// As [`estimate`].
pub fn of(sources: &[File], top: &str, step: &mut dyn FnMut(&str)) -> Result<Estimate, EstimateError> {
    let version = Command::new("yosys").arg("-V").output().map_err(EstimateError::Missing)?;
    let version = String::from_utf8_lossy(&version.stdout).trim().to_owned();
    if !version.starts_with("Yosys ") || version.lines().count() != 1 {
        let reason = "`yosys -V` does not name a version, so this is no working Yosys; install Debian's package yosys";
        return Err(EstimateError::Failed(reason.into()));
    }
    let mut sources: Vec<&File> = sources.iter().collect();
    sources.sort_by_key(|file| file_name(file));
    let script = script(&sources, top);
    let mut digest = Sha256::new();
    digest.update(&version);
    digest.update(&script);
    sources.iter().for_each(|file| digest.update(&file.text));
    let name: String = digest.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let folder = hoverlock_cache::folder()?.join("estimate");
    let netlist = folder.join(format!("{name}.json"));
    if !netlist.exists() {
        fs::create_dir_all(&folder).map_err(at(&folder))?;
        let work = tempfile::tempdir_in(&folder).map_err(at(&folder))?;
        synthesise(work.path(), &sources, &script, step)?;
        fs::rename(work.path().join("netlist.json"), &netlist).map_err(at(&netlist))?;
        // A netlist of this design has 13 MB; those of earlier versions of it would pile up.
        hoverlock_cache::prune(&folder, hoverlock_cache::MAX_UNUSED_AGE);
    } else {
        hoverlock_cache::touch(&netlist);
    }
    step("reading the netlist");
    let text = fs::read(&netlist).map_err(at(&netlist))?;
    let parsed: Netlist = serde_json::from_slice(&text)
        .map_err(|error| EstimateError::Failed(format!("{}: {error}; delete this file", netlist.display())))?;
    let mut flat = Flat::of(&parsed, top)?;
    let texts: BTreeMap<&str, &str> = sources.iter().flat_map(|file| modules(&file.text)).collect();
    let variants = name_variants(&mut flat, &texts, top);
    let memories = memories(&texts, &variants, &flat)?;
    derive(version, &flat, memories)
}

/// Gives the modules of a netlist the labels of their variants, because Yosys names a module with parameters by a hash
/// of their values. Returns the variants.
fn name_variants(flat: &mut Flat, texts: &BTreeMap<&str, &str>, top: &str) -> Vec<Variant> {
    let mut known: BTreeMap<String, Variant> =
        instances(texts, top).into_iter().map(|instance| (instance.path, instance.variant)).collect();
    let Flat { modules, instances, .. } = flat;
    let mut variants = Vec::new();
    for (at, name) in modules.iter_mut().enumerate() {
        let first = instances.iter().find(|instance| instance.module == at);
        let variant = first.and_then(|first| known.remove(&first.path));
        let variant = variant.unwrap_or_else(|| Variant { module: name.clone(), parameters: Vec::new() });
        *name = variant.label();
        variants.push(variant);
    }
    variants
}

fn at(path: &Path) -> impl FnOnce(std::io::Error) -> EstimateError {
    let path = PathBuf::from(path);
    move |source| EstimateError::File { path, source }
}

/// The name of a source in the folder where Yosys runs.
fn file_name(file: &File) -> &str {
    file.path.rsplit('/').next().unwrap_or_default()
}

fn script(sources: &[&File], top: &str) -> String {
    let read: String = sources.iter().map(|file| format!("read_verilog {}\n", file_name(file))).collect();
    format!("{read}synth_intel_alm -family arriav -noflatten -top {top}\nwrite_json netlist.json\n")
}

fn synthesise(folder: &Path, sources: &[&File], script: &str, step: &mut dyn FnMut(&str)) -> Result<(), EstimateError> {
    for file in sources {
        let path = folder.join(file_name(file));
        fs::write(&path, &file.text).map_err(at(&path))?;
    }
    let (run, log) = (folder.join("run.ys"), folder.join("stderr"));
    fs::write(&run, script).map_err(at(&run))?;
    let errors = fs::File::create(&log).map_err(at(&log))?;
    let mut yosys = Command::new("yosys")
        .current_dir(folder)
        .arg("run.ys")
        .stdout(Stdio::piped())
        .stderr(errors)
        .spawn()
        .map_err(EstimateError::Missing)?;
    // Each pass is announced like "2.25.3. Executing OPT_EXPR pass (...)".
    for line in yosys.stdout.take().map(BufReader::new).into_iter().flat_map(BufRead::lines).map_while(Result::ok) {
        if let Some((_, pass)) = line.split_once(". Executing ").filter(|(number, _)| number.len() < 16) {
            step(pass.split(" (").next().unwrap_or(pass).trim_end_matches('.'));
        }
    }
    let status = yosys.wait().map_err(EstimateError::Missing)?;
    if !status.success() {
        let text = fs::read_to_string(&log).unwrap_or_default();
        let reason = text.lines().find(|line| line.contains("ERROR: ")).unwrap_or("no reason given");
        return Err(EstimateError::Failed(reason.replacen("ERROR: ", "", 1)));
    }
    Ok(())
}
