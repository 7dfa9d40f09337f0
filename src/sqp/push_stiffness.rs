//! How the forces of pushed obstacles change with their poses.
//!
//! ```text
//! J = df/dz,   J += (df - J dz) dz^T / dz.dz
//! ```
//!
//! Broyden's rule (Dennis and Schnabel, Numerical Methods for Unconstrained Optimization, 8.1).
//! Where J has no part obstacles move freely and balance nothing. Lengths are those of the
//! scaled body, angles radians. Cost: nothing beside a solve.

use crate::linalg::DenseMatrix;
use crate::linalg::eigen::symmetric;
use crate::linalg::vector::{add_scaled, dot, norm, scale};
use crate::model::push::Control;

constants! {
    /// Singular value over the largest below which obstacles move freely.
    const FREE: f64 = 1e-7;
    /// Longest step, over the body's length and in radians.
    pub(crate) const LONGEST: f64 = 0.1;
    /// Motion of supports, in the same units, from which on J only seems to resist, against the push and
    /// along it: a search goes no farther than four lengths; chosen, no scene measures it.
    const ENDLESS: [f64; 2] = [LONGEST, 100.0];
}

/// J of some controls.
#[derive(Clone, Debug)]
pub(crate) struct PushStiffness {
    /// The components of poses that J belongs to.
    pub(crate) controls: Vec<Control>,
    /// J, column by column `[controls][controls]`.
    pub(crate) columns: Vec<Vec<f64>>,
}

/// What J says of a misfit, each `[controls]`.
pub(crate) struct PushStep {
    /// The motion that takes it off.
    pub(crate) step: Vec<f64>,
    /// What that leaves of it.
    pub(crate) rest: Vec<f64>,
    /// The motion that the rest does work along, of no particular length: in units in which components
    /// are alike it is the rest itself.
    pub(crate) free: Vec<f64>,
    /// Length of the motion as J has it, without the bound of a step.
    pub(crate) way: f64,
}

impl PushStiffness {
    /// `factor` J.
    pub(crate) fn times(mut self, factor: f64) -> Self {
        self.columns
            .iter_mut()
            .for_each(|column| scale(column, factor));
        self
    }

    /// Takes over that the step dz changed the forces by `change` `[controls]`.
    pub(crate) fn learn(&mut self, step: &[f64], change: &[f64]) {
        let square = dot(step, step);
        if !(square > 0.0 && square.is_finite()) {
            return;
        }
        let mut error = change.to_vec();
        for (column, part) in self.columns.iter().zip(step) {
            add_scaled(&mut error, -part, column);
        }
        for (column, part) in self.columns.iter_mut().zip(step) {
            add_scaled(column, part / square, &error);
        }
    }

    /// The shortest dz with J dz = -`misfit` as far as J reaches, and what is free of it.
    pub(crate) fn solve(&self, misfit: &[f64]) -> PushStep {
        let scales = self.scales();
        let columns = self.columns.iter().zip(&scales).map(|(column, own)| {
            let entries = column.iter().zip(&scales);
            entries
                .map(|(entry, scale)| entry / (own * scale))
                .collect()
        });
        let scaled = Self {
            controls: self.controls.clone(),
            columns: columns.collect(),
        };
        let misfit: Vec<f64> = misfit
            .iter()
            .zip(&scales)
            .map(|(f, scale)| f / scale)
            .collect();
        let (mut step, mut rest) = scaled.shortest(&misfit, &scales);
        let free = rest.iter().zip(&scales).map(|(rest, scale)| rest / scale);
        let free = free.collect();
        for ((step, rest), scale) in step.iter_mut().zip(&mut rest).zip(&scales) {
            *step /= scale;
            *rest *= scale;
        }
        let length = norm(&step);
        if length > LONGEST {
            scale(&mut step, LONGEST / length);
        }
        PushStep {
            step,
            rest,
            free,
            way: length,
        }
    }

    /// Unit of each component: one of obstacles, whose stiffnesses are alike; of supports the root
    /// of their own stiffness, for springs may be as stiff as they like.
    fn scales(&self) -> Vec<f64> {
        let diagonal = self.controls.iter().enumerate();
        let of_one = |(place, control): (usize, &Control)| {
            let own = self.columns[place][place].abs().sqrt();
            if control.is_of_support() && own > 0.0 {
                own
            } else {
                1.0
            }
        };
        diagonal.map(of_one).collect()
    }

    /// The same in units in which components are alike, `scales` of the others, of any length that is
    /// not endless.
    fn shortest(&self, misfit: &[f64], scales: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let size = misfit.len();
        let (mut step, mut rest) = (vec![0.0; size], misfit.to_vec());
        let mut normal = DenseMatrix::zeros(size, size);
        for i in 0..size {
            for j in 0..size {
                *normal.at_mut(i, j) = dot(&self.columns[i], &self.columns[j]);
            }
        }
        let directions = symmetric(&normal).unwrap_or_default();
        let images: Vec<Vec<f64>> = directions.iter().map(|v| self.product(v)).collect();
        let largest = images.iter().map(|image| norm(image)).fold(0.0, f64::max);
        for (direction, image) in directions.iter().zip(&images) {
            let square = dot(image, image);
            if square.sqrt() > FREE * largest {
                let part = dot(image, misfit) / square;
                if !self.is_endless((direction, scales), part, misfit) {
                    add_scaled(&mut step, -part, direction);
                    add_scaled(&mut rest, -part, image);
                }
            }
        }
        (step, rest)
    }

    /// Whether supports would move by `part` of a direction without an end, to take off `misfit`.
    fn is_endless(&self, (direction, scales): (&[f64], &[f64]), part: f64, misfit: &[f64]) -> bool {
        let motion = direction.iter().zip(scales);
        let motion: Vec<f64> = motion.map(|(own, scale)| part * own / scale).collect();
        let bound = ENDLESS[usize::from(part * dot(direction, misfit) > 0.0)];
        let moves_supports = self.controls.iter().any(|control| control.is_of_support());
        moves_supports && norm(&motion) > bound
    }

    /// J x.
    pub(crate) fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; x.len()];
        for (column, part) in self.columns.iter().zip(x) {
            add_scaled(&mut product, *part, column);
        }
        product
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::push::Part;

    /// Of a spring along the first axis and none along the second.
    fn spring(stiffness: f64) -> PushStiffness {
        let controls = [2, 0].map(|axis| Control {
            part: Part::Obstacle(0),
            axis,
        });
        PushStiffness {
            controls: controls.to_vec(),
            columns: vec![vec![stiffness, 0.0], vec![0.0, 0.0]],
        }
    }

    #[test]
    fn a_step_takes_off_what_the_spring_takes_up_and_leaves_the_rest() {
        let PushStep { step, rest, .. } = spring(20.0).solve(&[-1.0, 0.5]);
        assert!((step[0] - 0.05).abs() < 1e-15 && step[1].abs() < 1e-15);
        assert!(rest[0].abs() < 1e-15 && (rest[1] - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_support_on_a_slope_is_free_along_the_slope_however_small_its_errors_are() {
        let normal = [-0.2, 0.98];
        let controls = [0, 1].map(|axis| Control {
            part: Part::Support(0),
            axis,
        });
        let column = |k: usize| normal.iter().map(|part| 3.0 * normal[k] * part).collect();
        let mut slope = PushStiffness {
            controls: controls.to_vec(),
            columns: vec![column(0), column(1)],
        };
        slope.columns[0][0] += 1e-5;
        let PushStep {
            step, rest, free, ..
        } = slope.solve(&[0.0, 0.1]);
        assert!(norm(&step) < LONGEST && norm(&rest) > 0.01);
        assert!(dot(&free, &normal).abs() < 1e-4 * norm(&free));
    }

    #[test]
    fn steps_are_bounded() {
        let step = spring(1e-3).solve(&[-1.0, 0.0]).step;
        assert!((step[0] - LONGEST).abs() < 1e-15);
    }

    #[test]
    fn what_a_step_has_shown_is_learnt() {
        let mut stiffness = spring(20.0);
        stiffness.learn(&[0.1, 0.0], &[1.0, 0.2]);
        let PushStep { step, rest, .. } = stiffness.solve(&[1.0, 0.2]);
        assert!((step[0] + 0.1).abs() < 1e-15);
        assert!(norm(&rest) < 1e-15);
        // A step of no length says nothing.
        stiffness.learn(&[0.0, 0.0], &[1.0, 0.2]);
        assert!((stiffness.solve(&[1.0, 0.2]).step[0] + 0.1).abs() < 1e-15);
    }
}
