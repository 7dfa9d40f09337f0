//! The first strain on a way of deformation at which a law is not stable.

/// Stretch up to which a law is looked at, and its inverse: the range of other programs; chosen.
const FARTHEST: f64 = 10.0;
/// Strains that are looked at on a way, 0.6 % apart; chosen.
const STRAINS: u32 = 400;

/// The least logarithmic strain along a way that is not stable, to 1e-8; none where all are that
/// are looked at.
pub(super) fn first_unstable(is_stable: impl Fn(f64) -> bool) -> Option<f64> {
    let size = |place: u32| FARTHEST.ln() * f64::from(place) / f64::from(STRAINS);
    let last = (0..=STRAINS).find(|&place| !is_stable(size(place)))?;
    let [mut least, mut most] = [last.saturating_sub(1), last].map(size);
    for _ in 0..20 {
        let middle = 0.5 * (least + most);
        if is_stable(middle) {
            least = middle;
        } else {
            most = middle;
        }
    }
    Some(most)
}
