//! Supports whose prescribed values vary over their surface.

use super::{Faults, Parabola, Placed, ResolvedSupport, planes, rotates, values};
use crate::mesh::Mesh;
use crate::scene::{Profile, Step, Support};

/// The supports with their profiles.
pub(crate) fn resolve(
    supports: Vec<Placed<'_, Support>>,
    (steps, mesh): (&[Step], &Mesh),
    faults: &mut Faults,
) -> Vec<ResolvedSupport> {
    let resolve = |Placed { item, facets }: Placed<'_, Support>| {
        let (planes, patches) = match item.normal {
            Some(_) => planes::parted(mesh, (&item.name, &facets), steps),
            None => Default::default(),
        };
        let (oblique, patches) = if steps.iter().any(|step| rotates(step, &item.name)) {
            (Vec::new(), patches)
        } else {
            planes::oblique(mesh, patches)
        };
        ResolvedSupport {
            name: item.name.clone(),
            oblique,
            displacement: item.held(),
            normal: item.normal,
            planes,
            patches,
            profile: profile(item, &facets, mesh, faults),
            values: values::of_support(item, (&facets, mesh), faults),
            push: item.load.components(),
            spring: item.load.springs().map(Option::unwrap_or_default),
            about: item.load.about.unwrap_or_default(),
            facets,
        }
    };
    supports.into_iter().map(resolve).collect()
}

fn profile(
    support: &Support,
    facets: &[u32],
    mesh: &Mesh,
    faults: &mut Faults,
) -> Option<Parabola> {
    match support.profile {
        Profile::Constant => None,
        // A group that is missing has its own message.
        Profile::Parabolic if facets.is_empty() => None,
        Profile::Parabolic => {
            let path = format!("support.{}.profile", support.name);
            Parabola::over(mesh, facets, &path, faults)
        }
    }
}
