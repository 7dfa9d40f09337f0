//! What each pass does with the batches of one block, by the instruction set of the
//! machine.

use pulp::Simd;

use super::cells::{BatchLaw, BatchState, Batches};
use super::kernel::{BatchRun, store_volumes, vertex_pressures};
use super::laws::{Frozen, Pressures, Respond, Roots, Stiff, Tangent, Volumes};
use super::response::Response;
use crate::assembly::kernel::{Element, NodeLanes};
use crate::assembly::lanes::{Lanes, Pack, WIDTH};
use crate::assembly::simd::{BatchPass, prefetch_at};
use crate::assembly::transpose::{Row, Transpose};

pub(super) struct RespondPass<'a, const V: usize, const D: usize, const E: usize> {
    pub(super) cells: Batches<'a, V, D, E>,
    pub(super) x: &'a [Row],
    pub(super) y: &'a mut [Row],
}

impl<const V: usize, const D: usize, const E: usize> BatchPass for RespondPass<'_, V, D, E> {
    type Output = Response;
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) -> Response {
        let mut element = Element::zero();
        let zero = Pack::splat(simd, 0.0);
        let mut least: f64 = f64::INFINITY;
        let mut energy = 0.0;
        for (index, law) in self.cells.laws.iter().enumerate() {
            let mut energies = <Lanes>::zero();
            BatchRun {
                simd,
                transpose,
                x: self.x,
                y: &mut *self.y,
            }
            .run(
                self.cells.at(index),
                &mut element,
                |part, _, vertices| Respond {
                    law: law.load(simd, part),
                    by_point: law.by_point::<S>(part),
                    volume: law.volume(simd, part, self.cells.penalty),
                    pressures: vertex_pressures(simd, vertices, part),
                    volumes: [zero; V],
                    energy: zero,
                    least: [f64::INFINITY; WIDTH],
                },
                |part, done, vertices| {
                    store_volumes(&done.volumes, vertices, part);
                    done.energy.store(&mut energies, part);
                    least = done.least.into_iter().fold(least, f64::min);
                },
            );
            energy += energies.0.iter().sum::<f64>();
        }
        Response {
            energy,
            volume_change: 0.0,
            least_jacobian: 1.0 + least,
        }
    }
}

pub(super) struct LinearisePass<'a, const V: usize, const D: usize, const E: usize> {
    pub(super) cells: Batches<'a, V, D, E>,
    pub(super) states: &'a mut [Lanes],
    pub(super) x: &'a [Row],
    pub(super) y: &'a mut [Row],
}

impl<const V: usize, const D: usize, const E: usize> BatchPass for LinearisePass<'_, V, D, E> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
        let mut element = Element::zero();
        let states = self.states.chunks_exact_mut(self.cells.stride);
        for (index, (law, state)) in self.cells.laws.iter().zip(states).enumerate() {
            let (fields, rest) = state.split_at_mut(V * D * D + V);
            let (roots, rest) = rest.split_at_mut(self.cells.rule.len());
            let (hoops, tangents) = rest.split_at_mut(self.cells.hoops);
            let roots = std::cell::RefCell::new(roots);
            let hoops = std::cell::RefCell::new(hoops);
            let tangents = std::cell::RefCell::new(tangents);
            BatchRun {
                simd,
                transpose,
                x: self.x,
                y: &mut *self.y,
            }
            .run(
                self.cells.at(index),
                &mut element,
                |part, gradients, vertices| {
                    for (j, gradient) in gradients.iter().enumerate() {
                        for i in 0..D {
                            for k in 0..D {
                                gradient[i][k].store(&mut fields[(j * D + i) * D + k], part);
                            }
                        }
                    }
                    let pressures = vertex_pressures::<S, V>(simd, vertices, part);
                    for (lanes, value) in fields[V * D * D..].iter_mut().zip(pressures) {
                        value.store(lanes, part);
                    }
                    Roots {
                        part,
                        roots: &roots,
                        hoops: &hoops,
                        tangents: &tangents,
                        by_point: law.by_point::<S>(part),
                    }
                },
                |_, _, _| (),
            );
        }
    }
}

/// A pass over the batches that reads a state: the law of each part, and what it
/// leaves in the place of the pressure.
macro_rules! frozen_pass {
    ($pass:ident { $($field:ident: $kind:ty),* }, $make:expr, $finish:expr) => {
        pub(super) struct $pass<'a, const V: usize, const D: usize, const E: usize> {
            pub(super) cells: Batches<'a, V, D, E>,
            pub(super) states: &'a [Lanes],
            $(pub(super) $field: $kind,)*
            pub(super) x: &'a [Row],
            pub(super) y: &'a mut [Row],
        }

        impl<const V: usize, const D: usize, const E: usize> BatchPass for $pass<'_, V, D, E> {
            type Output = ();
            #[inline(always)]
            fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
                let mut element = Element::zero();
                let (stride, points) = (self.cells.stride, self.cells.rule.len());
                let hoops = self.cells.hoops;
                let laws = self.cells.laws.iter();
                for (index, (law, state)) in
                    laws.zip(self.states.chunks_exact(stride)).enumerate()
                {
                    prefetch_at(self.cells.batches, index + 1);
                    let state = BatchState::<V, D>(state);
                    BatchRun { simd, transpose, x: self.x, y: &mut *self.y }.run(
self.cells.at(index),
&mut element,
                        |part, _, vertices| {
                            let frozen = Frozen {
                                simd,
                                part,
                                gradients: state.gradients(simd, part),
                                pressures: state.pressures(simd, part),
                                volume: law.volume(simd, part, self.cells.penalty),
                                roots: state.roots(points),
                                hoops: state.hoops(points, hoops),
                                tangents: state.tangents(points, hoops),
                            };
                            let at = At { simd, part, law, vertices };
                            $make(frozen, at $(, self.$field)*)
                        },
                        |part, done, vertices| $finish(done, part, vertices),
                    );
                }
            }
        }
    };
}

/// One part of a batch at work.
struct At<'a, S, const V: usize> {
    simd: S,
    part: usize,
    law: &'a BatchLaw,
    vertices: &'a NodeLanes<V>,
}

frozen_pass!(
    TangentPass {},
    |frozen, at: At<'_, S, V>| Tangent {
        frozen,
        law: at.law.load(at.simd, at.part),
        changes: vertex_pressures(at.simd, at.vertices, at.part),
        volumes: [Pack::splat(at.simd, 0.0); V],
    },
    |done: Tangent<'_, S, V, D>, part, vertices| store_volumes(&done.volumes, vertices, part)
);

frozen_pass!(
    StiffPass { volumetric: f64 },
    |frozen, at: At<'_, S, V>, volumetric| {
        Stiff {
            frozen,
            volumetric: at.law.modulus(at.simd, at.part) * volumetric,
            law: at.law.load(at.simd, at.part),
        }
    },
    |_, _, _| ()
);

frozen_pass!(
    VolumePass {},
    |frozen, at: At<'_, S, V>| Volumes {
        frozen,
        volumes: [Pack::splat(at.simd, 0.0); V],
    },
    |done: Volumes<'_, S, V, D>, part, vertices| store_volumes(&done.volumes, vertices, part)
);

frozen_pass!(
    PressurePass {},
    |frozen, at: At<'_, S, V>| Pressures {
        frozen,
        changes: vertex_pressures(at.simd, at.vertices, at.part),
    },
    |_, _, _| ()
);
