//! Supports whose prescribed values vary over their surface.

use super::{Faults, Parabola, Placed, ResolvedSupport, values};
use crate::contact::patches::smooth_patches;
use crate::mesh::Mesh;
use crate::scene::{Profile, Support};

/// The supports with their profiles.
pub(crate) fn resolve(
    supports: Vec<Placed<'_, Support>>,
    mesh: &Mesh,
    faults: &mut Faults,
) -> Vec<ResolvedSupport> {
    let supports = supports.into_iter();
    supports
        .map(|Placed { item, facets }| ResolvedSupport {
            name: item.name.clone(),
            displacement: item.displacement,
            normal: item.normal,
            patches: match item.normal {
                Some(_) => smooth_patches(mesh, &facets),
                None => Vec::new(),
            },
            profile: profile(item, &facets, mesh, faults),
            values: values::of_support(item, (&facets, mesh), faults),
            facets,
        })
        .collect()
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
