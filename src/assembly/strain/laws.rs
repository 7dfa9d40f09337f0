//! What happens at the points of an element in each pass.

use pulp::Simd;

use super::by_point::{self, LaneLaw, TANGENT};
use super::kernel::{PointLaw, Site};
use super::points::{VertexGradients, at_point};
use crate::assembly::lanes::{Lanes, Pack, WIDTH};
use crate::geometry::tensor::{Tensor, plus, volume_change};
use crate::material::{Deformation, InvariantLaw};

/// sum_j lambda_j p_j.
#[inline(always)]
pub(super) fn interpolate<S: Simd, const V: usize>(
    hats: &[Pack<S>; V],
    values: &[Pack<S>; V],
) -> Pack<S> {
    let mut sum = hats[0] * values[0];
    for j in 1..V {
        sum = sum.plus_product(hats[j], values[j]);
    }
    sum
}

/// Adds `weight` lambda_j `value` to the moments.
#[inline(always)]
pub(super) fn add_moments<S: Simd, const V: usize>(
    moments: &mut [Pack<S>; V],
    hats: &[Pack<S>; V],
    value: Pack<S>,
) {
    for (moment, hat) in moments.iter_mut().zip(hats) {
        *moment = moment.plus_product(*hat, value);
    }
}

/// J^(-1/3) from J - 1; one where the element is turned inside out, and the
/// least J tells.
#[inline(always)]
pub(super) fn root<S: Simd>(volume_change: Pack<S>) -> Pack<S> {
    volume_change.each(|change| {
        if change > -1.0 {
            (1.0 + change).cbrt().recip()
        } else {
            1.0
        }
    })
}

/// s mu / 2 (J - 1 + p / K)^2, whose p is a number.
#[derive(Clone, Copy)]
pub(super) struct VolumeTerm<S: Simd> {
    /// s mu.
    pub(super) stiffness: Pack<S>,
    /// 1 / K.
    pub(super) compliance: Pack<S>,
}

impl<S: Simd> VolumeTerm<S> {
    /// s mu (J - 1 + p / K), and its change with those of J and p.
    #[inline(always)]
    fn pressure(&self, volume_change: Pack<S>, pressure: Pack<S>) -> Pack<S> {
        self.stiffness * volume_change.plus_product(self.compliance, pressure)
    }

    /// 1 - s mu / K: the share of a pressure that pushes.
    #[inline(always)]
    pub(super) fn pushed_share(&self, simd: S) -> Pack<S> {
        Pack::splat(simd, 1.0) - self.stiffness * self.compliance
    }

    #[inline(always)]
    fn energy(&self, volume_change: Pack<S>, pressure: Pack<S>) -> Pack<S> {
        let defect = volume_change.plus_product(self.compliance, pressure);
        self.stiffness * defect * defect * 0.5
    }
}

/// Stress, energy and volume at a state.
pub(super) struct Respond<'a, S: Simd, const V: usize> {
    pub(super) law: InvariantLaw<Pack<S>>,
    pub(super) by_point: &'a [LaneLaw],
    pub(super) volume: VolumeTerm<S>,
    pub(super) pressures: [Pack<S>; V],
    /// int lambda_j (J - 1).
    pub(super) volumes: [Pack<S>; V],
    pub(super) energy: Pack<S>,
    /// Least J - 1 of each element.
    pub(super) least: [f64; WIDTH],
}

impl<S: Simd, const V: usize> PointLaw<S, V> for Respond<'_, S, V> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let change = volume_change(gradient);
        let mut lanes = <Lanes>::zero();
        change.store(&mut lanes, 0);
        for (least, value) in self.least.iter_mut().zip(lanes.0).take(S::F64_LANES) {
            *least = least.min(value);
        }
        let at = Deformation::new(*gradient, root(change));
        let pressure = interpolate(site.hats, &self.pressures);
        let energy = self.law.energy(&at) + self.volume.energy(change, pressure);
        self.energy = self.energy.plus_product(site.weight, energy);
        add_moments(&mut self.volumes, site.hats, site.weight * at.volume_change);
        let pressure = pressure - self.volume.pressure(change, pressure);
        let mut stress = plus(&self.law.stress(&at), -pressure, &at.cofactor);
        if !self.by_point.is_empty() {
            let energy = by_point::add_response(self.by_point, gradient, &mut stress);
            self.energy = self.energy.plus_product(site.weight, energy);
        }
        stress
    }
}

/// J^(-1/3) at the points, and the tangents of laws by point.
pub(super) struct Roots<'a> {
    pub(super) part: usize,
    /// Shared by the parts of a batch.
    pub(super) roots: &'a std::cell::RefCell<&'a mut [Lanes]>,
    /// Stretches around an axis less one; empty where there is none.
    pub(super) hoops: &'a std::cell::RefCell<&'a mut [Lanes]>,
    pub(super) tangents: &'a std::cell::RefCell<&'a mut [Lanes]>,
    pub(super) by_point: &'a [LaneLaw],
}

impl<S: Simd, const V: usize> PointLaw<S, V> for Roots<'_> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        root(volume_change(gradient)).store(&mut self.roots.borrow_mut()[site.index], self.part);
        if let Some(hoop) = self.hoops.borrow_mut().get_mut(site.index) {
            gradient[2][2].store(hoop, self.part);
        }
        if !self.by_point.is_empty() {
            let tangents = &mut self.tangents.borrow_mut()[site.index * TANGENT..];
            by_point::store_tangent(self.by_point, gradient, tangents, self.part);
        }
        *gradient
    }
}

/// What a state leaves for products, in one part of a batch.
pub(super) struct Frozen<'a, S: Simd, const V: usize, const D: usize> {
    pub(super) simd: S,
    pub(super) part: usize,
    pub(super) gradients: VertexGradients<S, V, D>,
    pub(super) pressures: [Pack<S>; V],
    pub(super) volume: VolumeTerm<S>,
    /// Of all points.
    pub(super) roots: &'a [Lanes],
    /// Stretches around an axis less one; empty where there is none.
    pub(super) hoops: &'a [Lanes],
    /// Of laws by point at all points; empty where there are none.
    pub(super) tangents: &'a [Lanes],
}

impl<S: Simd, const V: usize, const D: usize> Frozen<'_, S, V, D> {
    #[inline(always)]
    pub(super) fn at(&self, site: &Site<'_, S, V>) -> Deformation<Pack<S>> {
        let mut gradient = site.on_curved(at_point(self.simd, site.hats, &self.gradients));
        if let Some(hoop) = self.hoops.get(site.index) {
            gradient[2][2] = Pack::load(self.simd, hoop, self.part);
        }
        let root = Pack::load(self.simd, &self.roots[site.index], self.part);
        Deformation::new(gradient, root)
    }

    /// What pushes on the volume: p - s mu (J - 1 + p / K).
    #[inline(always)]
    fn pressure(&self, hats: &[Pack<S>; V], at: &Deformation<Pack<S>>) -> Pack<S> {
        let pressure = interpolate(hats, &self.pressures);
        pressure - self.volume.pressure(at.volume_change, pressure)
    }

    /// Adds the tangent of laws by point in the direction `change`.
    #[inline(always)]
    fn add_by_point(&self, point: usize, change: &Tensor<Pack<S>>, stress: &mut Tensor<Pack<S>>) {
        if !self.tangents.is_empty() {
            let tangents = &self.tangents[point * TANGENT..];
            by_point::add_tangent((self.simd, self.part), tangents, change, stress);
        }
    }
}

impl<S: Simd, const V: usize, const D: usize> Frozen<'_, S, V, D> {
    /// Change of the stress with the displacement alone, `volumetric` times dJ cof F added
    /// to it, and dJ.
    #[inline(always)]
    fn stiffness(
        &self,
        site: &Site<'_, S, V>,
        (law, volumetric): (&InvariantLaw<Pack<S>>, Pack<S>),
        gradient: &Tensor<Pack<S>>,
    ) -> (Tensor<Pack<S>>, Pack<S>) {
        let at = self.at(site);
        let pressure = self.pressure(site.hats, &at);
        let (mut stress, volume) = law.tangent(&at, pressure, gradient);
        self.add_by_point(site.index, gradient, &mut stress);
        let stiffness = volumetric + self.volume.stiffness;
        (plus(&stress, stiffness * volume, &at.cofactor), volume)
    }
}

/// Tangent with changes of displacement and pressure.
pub(super) struct Tangent<'a, S: Simd, const V: usize, const D: usize> {
    pub(super) frozen: Frozen<'a, S, V, D>,
    pub(super) law: InvariantLaw<Pack<S>>,
    /// Changes of the pressure.
    pub(super) changes: [Pack<S>; V],
    /// int lambda_j dJ.
    pub(super) volumes: [Pack<S>; V],
}

impl<S: Simd, const V: usize, const D: usize> PointLaw<S, V> for Tangent<'_, S, V, D> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let at = self.frozen.at(site);
        let pressure = self.frozen.pressure(site.hats, &at);
        let (mut stress, volume) = self.law.tangent(&at, pressure, gradient);
        self.frozen.add_by_point(site.index, gradient, &mut stress);
        add_moments(&mut self.volumes, site.hats, site.weight * volume);
        let change = interpolate(site.hats, &self.changes);
        let pushed = self.frozen.volume.pressure(volume, change) - change;
        plus(&stress, pushed, &at.cofactor)
    }
}

/// Tangent and volumes with changes of the displacement only.
pub(super) struct Columns<'a, S: Simd, const V: usize, const D: usize> {
    pub(super) frozen: Frozen<'a, S, V, D>,
    pub(super) law: InvariantLaw<Pack<S>>,
    /// Times dJ cof F, added to the tangent.
    pub(super) volumetric: Pack<S>,
    /// int lambda_j dJ.
    pub(super) volumes: [Pack<S>; V],
}

impl<S: Simd, const V: usize, const D: usize> PointLaw<S, V> for Columns<'_, S, V, D> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let law = (&self.law, self.volumetric);
        let (stress, volume) = self.frozen.stiffness(site, law, gradient);
        add_moments(&mut self.volumes, site.hats, site.weight * volume);
        stress
    }
}

/// Tangent with changes of the displacement only.
pub(super) struct Stiff<'a, S: Simd, const V: usize, const D: usize> {
    pub(super) frozen: Frozen<'a, S, V, D>,
    pub(super) law: InvariantLaw<Pack<S>>,
    /// Times dJ cof F, added to the tangent.
    pub(super) volumetric: Pack<S>,
}

impl<S: Simd, const V: usize, const D: usize> PointLaw<S, V> for Stiff<'_, S, V, D> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let law = (&self.law, self.volumetric);
        self.frozen.stiffness(site, law, gradient).0
    }
}

/// cof F : grad v.
pub(super) struct Volumes<'a, S: Simd, const V: usize, const D: usize> {
    pub(super) frozen: Frozen<'a, S, V, D>,
    pub(super) volumes: [Pack<S>; V],
}

impl<S: Simd, const V: usize, const D: usize> PointLaw<S, V> for Volumes<'_, S, V, D> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let at = self.frozen.at(site);
        let volume = crate::geometry::tensor::contract(&at.cofactor, gradient);
        add_moments(&mut self.volumes, site.hats, site.weight * volume);
        *gradient
    }
}

/// -(1 - s mu / K) p cof F for a pressure.
pub(super) struct Pressures<'a, S: Simd, const V: usize, const D: usize> {
    pub(super) frozen: Frozen<'a, S, V, D>,
    pub(super) changes: [Pack<S>; V],
}

impl<S: Simd, const V: usize, const D: usize> PointLaw<S, V> for Pressures<'_, S, V, D> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, _gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let at = self.frozen.at(site);
        let change = interpolate(site.hats, &self.changes);
        let volume = &self.frozen.volume;
        let pushed = volume.stiffness * volume.compliance * change - change;
        crate::geometry::tensor::scaled(pushed, &at.cofactor)
    }
}
