//! Builds models from Verilog, for Python.

use std::path::PathBuf;

use hoverlock_harness::build::{self, Build, Constant, Initial, Parameter, Trace};
use hoverlock_harness::coverage;
use hoverlock_harness::model;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt};

use crate::errors;

/// A built model, from which simulations are created.
///
/// >>> library = design.compile()
/// >>> library.top, library.warnings, library.constants
#[pyclass(module = "hoverlock", frozen)]
pub struct Library {
    pub library: model::Library,
}

#[pymethods]
impl Library {
    /// The top module's name.
    #[getter]
    fn top(&self) -> &str {
        self.library.top()
    }

    /// Verilator's warnings, one line each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.library.warnings().iter().map(ToString::to_string).collect()
    }

    /// Parameters of all instances: name below the top module, and value.
    #[getter]
    fn constants<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let value = |constant: &Constant| match constant {
            Constant::Number(number) => number.into_bound_py_any(py),
            Constant::Wide(digits) => py.get_type::<PyInt>().call1((digits, 16)),
            Constant::Real(number) => number.into_bound_py_any(py),
            Constant::Text(text) => text.into_bound_py_any(py),
        };
        self.library.constants().iter().map(|(name, constant)| Ok((name.clone(), value(constant)?))).collect()
    }

    /// Names of all variables below the top module, accessible or not.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.library.names().to_vec()
    }

    fn __repr__(&self) -> String {
        format!("<Library {}>", self.library.top())
    }
}

/// Coverage counts by position in the Verilog, merged over runs.
///
/// >>> total = Coverage()
/// >>> total.add("one.dat")
/// >>> total.met("line")
/// (17, 20)
#[pyclass(module = "hoverlock")]
#[derive(Default)]
pub struct Coverage(coverage::Coverage);

#[pymethods]
impl Coverage {
    #[new]
    fn new() -> Coverage {
        Coverage::default()
    }

    /// Adds a file that a run wrote with `write_coverage`.
    fn add(&mut self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let counts = coverage::Coverage::read(&path).map_err(|e| errors::exception(py, e.into()))?;
        self.0.merge(&counts);
        Ok(())
    }

    /// The number of points that were hit, and the number of all points, of one kind (`line`, `branch`, `toggle`,
    /// `user`) or of all kinds.
    #[pyo3(signature = (kind = ""))]
    fn met(&self, kind: &str) -> (usize, usize) {
        self.0.ratio(kind)
    }

    /// The points that were never hit: file, line, kind and a description of the point.
    fn missed(&self) -> Vec<(String, u32, String, String)> {
        self.0.missed().map(|p| (p.file.clone(), p.line, p.kind.clone(), p.what.clone())).collect()
    }

    /// The counts as an LCOV tracefile, which `genhtml` and editors read.
    fn lcov(&self) -> String {
        self.0.to_lcov()
    }
}

/// Builds a model, or loads it from the cache. The interpreter's lock is released meanwhile.
///
/// # Errors
/// `BuildError` if it does not build, `TypeError` or `ValueError` for an argument that is no Verilog value.
#[pyfunction]
#[pyo3(signature = (top, sources, *, includes = vec![], parameters = None, defines = None, flags = vec![],
                    internals = vec![], forceable = vec![], waves = None, coverage = false, random_initial = false,
                    assertions = true,
                    warnings_are_errors = false, timescale = None, verilator = None, cache = None))]
#[allow(clippy::too_many_arguments, reason = "keywords in Python")]
pub fn compile(
    py: Python<'_>,
    top: &str,
    sources: Vec<PathBuf>,
    includes: Vec<PathBuf>,
    parameters: Option<&Bound<'_, PyDict>>,
    defines: Option<&Bound<'_, PyDict>>,
    flags: Vec<String>,
    internals: Vec<String>,
    forceable: Vec<String>,
    waves: Option<&str>,
    coverage: bool,
    random_initial: bool,
    assertions: bool,
    warnings_are_errors: bool,
    timescale: Option<&str>,
    verilator: Option<PathBuf>,
    cache: Option<PathBuf>,
) -> PyResult<Library> {
    let trace = match waves {
        None => Trace::None,
        Some("vcd") => Trace::Vcd,
        Some("fst") => Trace::Fst,
        Some(other) => return Err(PyValueError::new_err(format!("waves are 'vcd' or 'fst', not '{other}'"))),
    };
    let mut build = Build::new(top)
        .sources(sources)
        .trace(trace)
        .coverage(if coverage { build::Coverage::ALL } else { build::Coverage::default() })
        .initial(if random_initial { Initial::Random } else { Initial::Zero })
        .assertions(assertions)
        .warnings_are_errors(warnings_are_errors);
    for folder in includes {
        build = build.include(folder);
    }
    for (name, value) in parameters.into_iter().flatten() {
        build = build.parameter(name.extract::<String>()?, parameter(&value)?);
    }
    for (name, value) in defines.into_iter().flatten() {
        let name: String = name.extract()?;
        build = if value.is_none() { build.define(name) } else { build.define_as(name, value.str()?.to_str()?) };
    }
    for flag in flags {
        build = build.verilator_flag(flag);
    }
    for pattern in internals {
        build = build.internal(pattern);
    }
    for pattern in forceable {
        build = build.forceable(pattern);
    }
    if let Some(text) = timescale {
        build = build.timescale(text);
    }
    if let Some(path) = verilator {
        build = build.verilator(path);
    }
    if let Some(folder) = cache {
        build = build.cache(folder);
    }
    let library = py.detach(|| build.compile()).map_err(|e| errors::of_build(&e))?;
    Ok(Library { library })
}

/// Converts a Python value into a parameter of the top module.
fn parameter(value: &Bound<'_, PyAny>) -> PyResult<Parameter> {
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Parameter::Integer(i128::from(flag.is_true())));
    }
    if let Ok(number) = value.extract::<i64>() {
        return Ok(Parameter::Integer(i128::from(number)));
    }
    if let Ok(number) = value.cast::<PyInt>() {
        let (sign, size) = if number.lt(0)? { ("-", number.neg()?) } else { ("", number.clone().into_any()) };
        let bits: u32 = size.call_method0("bit_length")?.extract()?;
        // One bit more, for the sign.
        return Ok(Parameter::Verilog(format!("{sign}{}'sh{}", bits + 1, size.call_method1("__format__", ("x",))?)));
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        // With its decimal point, by which Verilog knows that it is a `real`.
        return Ok(Parameter::Verilog(number.repr()?.to_string()));
    }
    if let Ok(text) = value.extract::<String>() {
        if let Some(inner) = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')) {
            return Ok(Parameter::Text(inner.to_owned()));
        }
        return Ok(if is_number(&text) { Parameter::Verilog(text) } else { Parameter::Text(text) });
    }
    Err(PyTypeError::new_err(format!("a parameter is a number or a string, not {}", value.repr()?)))
}

/// Returns `true` if a text is a Verilog number: `32`, `-3`, `8'hff`, `1.5`, `2e-3`.
fn is_number(text: &str) -> bool {
    let digits = |text: &str| {
        text.starts_with(|c: char| c.is_ascii_digit()) && text.chars().all(|c| c.is_ascii_digit() || c == '_')
    };
    let unsigned = text.strip_prefix('-').unwrap_or(text);
    if let Some((size, rest)) = unsigned.split_once('\'') {
        let rest = rest.strip_prefix(['s', 'S']).unwrap_or(rest);
        let mut value = rest.chars();
        let radix = match value.next().map(|c| c.to_ascii_lowercase()) {
            Some('b') => 2,
            Some('o') => 8,
            Some('d') => 10,
            Some('h') => 16,
            _ => return false,
        };
        let value = value.as_str();
        return (size.is_empty() || digits(size))
            && !value.is_empty()
            && value.chars().all(|c| c == '_' || c.is_digit(radix));
    }
    digits(unsigned) || (unsigned.starts_with(|c: char| c.is_ascii_digit()) && unsigned.parse::<f64>().is_ok())
}
