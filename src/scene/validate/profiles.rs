//! Supports whose prescribed values vary over their surface.

use super::{Faults, Parabola, Placed, ResolvedSupport, planes, rotates, values};
use crate::mesh::Mesh;
use crate::scene::{ElementKind, Profile, Scene, Step, Support};

/// The supports with their profiles.
pub(crate) fn resolve(
    supports: Vec<Placed<'_, Support>>,
    (scene, steps, mesh): (&Scene, &[Step], &Mesh),
    faults: &mut Faults,
) -> Vec<ResolvedSupport> {
    let resolve = |Placed { item, facets }: Placed<'_, Support>| {
        let (planes, patches) = match item.normal {
            Some(_) => planes::parted(mesh, (&item.name, &facets), steps),
            None => Default::default(),
        };
        // Elements that are compared hold components alone.
        let is_own = matches!(
            scene.solver.element.named(),
            None | Some(ElementKind::TaylorHood)
        );
        let (oblique, patches) = if is_own && !steps.iter().any(|step| rotates(step, &item.name)) {
            planes::oblique(mesh, patches)
        } else {
            (Vec::new(), patches)
        };
        ResolvedSupport {
            name: item.name.clone(),
            oblique,
            displacement: item.displacement,
            normal: item.normal,
            planes,
            patches,
            profile: profile(item, &facets, mesh, faults),
            values: values::of_support(item, (&facets, mesh), faults),
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
