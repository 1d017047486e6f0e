//! Border rules of recursive filters.
//!
//! A two-sided filter runs a causal pass, `u[n]` from `x[0 ..= n]`, then an anticausal one, `v[n]` from `u[n ..]`.
//! Before `x[0]` the border sample is repeated without end, `u[-1] = u[-2] = .. = x[0]`; the pass
//! is in its steady state there. After `x[N-1]` there are two rules:
//!
//! - [`Border::Held`]: each pass repeats the last sample of *its own* input, `v[N] = v[N+1] = .. = u[N-1]`. The
//!   hardware does this, because it no longer has the input.
//! - [`Border::ConstantExtension`]: the *original* input continues as `x[N-1]` without end. Then `u` still moves
//!   towards `x[N-1]` after the border, and `v[N]`, `v[N+1]` are the outputs of the anticausal pass over the extended
//!   signal (Triggs and Sdika 2006, "Boundary conditions for Young-van Vliet recursive filtering").
//!
//! Triggs and Sdika give a closed form for one section of third order. Here it is found for any cascade: let
//! `w` hold the last two outputs of every causal section less `x[N-1]`. After the border `w` develops without input,
//! `w[k+1] = F w[k]`. The anticausal section `v[k] = b u[k] + a1 v[k+1] + a2 v[k+2]` is linear in `w[k]` too, `v[k] = l
//! w[k]` with a row `l`, so `l (I - a1 F - a2 F^2) = b l'` where `l'` is the row of its input. Hence `v[N] = x[N-1] + l
//! F w[N-1]`, and so on.

use super::cascade::Section;
use nalgebra::{DMatrix, RowDVector};

/// The signal after the last sample of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Border {
    /// Each one-sided pass sees its own input with the border sample repeated.
    #[default]
    Held,
    /// The original input continues with its border sample without end.
    ConstantExtension,
}

/// The rows that give the first two outputs behind the border from `w`, for each anticausal section of a cascade.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Extension {
    /// `[l F, l F^2]` of each section, each as long as `w`: two entries for each causal section, the later sample
    /// first.
    pub rows: Vec<[Vec<f64>; 2]>,
}

impl Extension {
    /// Computes the rows of a cascade with the same sections in both passes.
    pub fn of(sections: &[Section]) -> Self {
        let size = 2 * sections.len();
        let step = step_matrix(sections);
        let step_twice = &step * &step;
        let mut input = RowDVector::zeros(size);
        input[size - 2] = 1.0;
        let mut rows = Vec::with_capacity(sections.len());
        for section in sections {
            let system = DMatrix::identity(size, size) - &step * section.a[0] - &step_twice * section.a[1];
            // l S = b l'  <=>  S^T l^T = b l'^T. The eigenvalues of S are products 1 - p_i p_j of poles inside the unit
            // circle: never 0.
            let output = system
                .transpose()
                .lu()
                .solve(&(input.transpose() * section.b()))
                .expect("poles inside the unit circle make the system regular")
                .transpose();
            let row = |matrix: &DMatrix<f64>| (&output * matrix).iter().copied().collect();
            rows.push([row(&step), row(&step_twice)]);
            input = output;
        }
        Self { rows }
    }
}

/// Returns `F`, one step of the causal cascade with zero input, each section fed by the one before it.
fn step_matrix(sections: &[Section]) -> DMatrix<f64> {
    let size = 2 * sections.len();
    let mut step = DMatrix::zeros(size, size);
    for (i, section) in sections.iter().enumerate() {
        let (now, before) = (2 * i, 2 * i + 1);
        if i > 0 {
            let fed = step.row(now - 2) * section.b();
            step.row_mut(now).copy_from(&fed);
        }
        step[(now, now)] += section.a[0];
        step[(now, before)] += section.a[1];
        step[(before, now)] = 1.0;
    }
    step
}
