//! The scenes of the report, those of its chapters and those of studies only.

use crate::family::Family;
use crate::family::MeshSource::{self, Cube, Gmsh};
use crate::family::Quantity::{
    self, ContactPressure, ContactRadius, DisplacementH1, DisplacementL2, Force, PressureL2,
    StrainEnergy, TangentialForce,
};
use crate::shaped::Shape;

const CUBE_BEND: &str = include_str!("../examples/cube-bend.toml");
const BENT: &str = include_str!("bent.toml");
const CONTRAST: &str = include_str!("contrast.toml");
const CUBE: MeshSource = Cube(Shape::Plain);
/// The default, and the space that those of other solvers come closest to.
const SPACES: &[&str] = &["auto", "contact_space=linear"];
const FRICTION: &[Quantity] = &[Force, TangentialForce];

/// All families.
pub(crate) const FAMILIES: &[Family] = &[
    Family::new(
        "A1m",
        include_str!("../examples/manufactured.toml"),
        CUBE,
        "Incompressible unit cube with a manufactured solution; the errors are exact, \
         divided by the norms of the exact fields.",
    )
    .measured(
        &[6, 10, 16, 24, 34],
        &[6, 10, 16],
        &[DisplacementL2, DisplacementH1, PressureL2],
    ),
    Family::new(
        "cube-bend",
        CUBE_BEND,
        CUBE,
        "Incompressible unit cube, clamped on one side and sheared on the opposite one; \
         edge singularities set the order.",
    )
    .measured(&[6, 10, 16, 24, 34], &[6, 10, 16], &[StrainEnergy]),
    Family::new(
        "hertz-sphere",
        include_str!("../examples/hertz-sphere.toml"),
        Gmsh("indent"),
        "A rigid sphere pressed into an incompressible block (a quarter is solved), \
         meshes refined under the contact.",
    )
    .of_a_quarter()
    .measured(
        &[1, 2, 3, 4, 5],
        &[1, 2, 3, 4],
        &[StrainEnergy, Force, ContactPressure, ContactRadius],
    ),
    Family::new(
        "hertz-rough",
        include_str!("../examples/hertz-sphere.toml"),
        Gmsh("indent"),
        "The rigid sphere with Coulomb friction, coefficient 0.3: the middle of the contact \
         sticks, its rim slips.",
    )
    .with(&["obstacle.0.friction=0.3"])
    .of_a_quarter(),
    Family::new(
        "cube-elastic",
        CUBE_BEND,
        CUBE,
        "The bent cube of a compressible material, Poisson ratio 0.3, displacement \
         only.",
    )
    .with(&["material.body.poisson_ratio=0.3"]),
    Family::new(
        "hertz-plane",
        include_str!("../examples/hertz-plane.toml"),
        Gmsh("hemi"),
        "A rigid plane pressed against an incompressible half ball (a quarter is \
         solved), meshes refined at the pole. The largest contact pressure is that of \
         one vertex: it does not fall regularly with the mesh size.",
    )
    .of_a_quarter()
    .measured(
        &[1, 2, 3, 4, 5],
        &[1, 2, 3, 4],
        &[Force, StrainEnergy, ContactPressure, ContactRadius],
    ),
    Family::new(
        "mr-uniax",
        include_str!("../examples/mr-uniax.toml"),
        CUBE,
        "A Mooney-Rivlin cube pressed to three quarters of its height between \
         frictionless planes, five increments: a homogeneous state, exact on every mesh \
         with every rule, so that its error is that of the algebra alone.",
    )
    .measured(&[6, 10, 16], &[6], &[Force, StrainEnergy]),
    Family::new(
        "mr-block",
        include_str!("../examples/mr-block.toml"),
        CUBE,
        "A Mooney-Rivlin cube bonded to its base and pressed to three quarters of its \
         height by a frictionless plane, ten increments; the edges of the base set the \
         order.",
    )
    .measured(&[6, 10, 16], &[6], &[Force, StrainEnergy]),
    Family::new(
        "mr-sphere",
        include_str!("../examples/mr-sphere.toml"),
        Gmsh("indent"),
        "A rigid sphere pressed deep into a Mooney-Rivlin block (a quarter is solved), \
         five increments, meshes refined under the contact. The travel ends close to \
         the limit of stability, which comes earlier on finer meshes: l4 does not reach \
         it.",
    )
    .of_a_quarter()
    .measured(
        &[1, 2, 3, 4],
        &[1, 2],
        &[Force, StrainEnergy, ContactPressure, ContactRadius],
    ),
    Family::new(
        "cube-drag",
        include_str!("../examples/cube-drag.toml"),
        CUBE,
        "A compressible cube (Poisson ratio 0.3), held below; a rough plate (Coulomb friction, \
         coefficient 0.3) presses it and drags it until a third of the contact slips. All of its \
         top is in contact: much friction for so small a body. Other solvers have the same \
         increments and meshes, but other contact conditions: equal meshes are not equal errors.",
    )
    .measured(&[4, 6, 10], &[4], FRICTION)
    .by(SPACES),
    Family::new(
        "hertz-press",
        include_str!("../examples/hertz-plane.toml"),
        Gmsh("hemi"),
        "A rough plane (Coulomb friction, coefficient 0.3) pressed in four increments against \
         a compressible half ball (Poisson ratio 0.3; a quarter is solved): the middle of the \
         contact sticks, its rim slips outwards. The tangential force is that on the quarter, \
         times four. Contact conditions differ: equal meshes are not equal errors.",
    )
    .with(&[
        "material.body.poisson_ratio=0.3",
        "obstacle.0.friction=0.3",
        "step.0.increments=4",
    ])
    .of_a_quarter()
    .measured(&[1, 2, 3, 4], &[1, 2], FRICTION)
    .by(SPACES),
    Family::new(
        "cube-flat-10",
        BENT,
        Cube(Shape::Flat(10)),
        "The bent cube, cells ten times as wide as high.",
    ),
    Family::new(
        "cube-flat-100",
        BENT,
        Cube(Shape::Flat(100)),
        "The bent cube, cells a hundred times as wide as high.",
    ),
    Family::new(
        "cube-tall-10",
        BENT,
        Cube(Shape::Tall(10)),
        "The bent cube, cells ten times as high as wide.",
    ),
    Family::new(
        "cube-slivers",
        BENT,
        Cube(Shape::Slivers),
        "The bent cube, inner vertices moved at random.",
    ),
    Family::new(
        "layer-stiff",
        CONTRAST,
        Cube(Shape::Layer),
        "A layer along the cells, a million times as stiff.",
    )
    .with(&["material.inclusion.shear_modulus=1e6"]),
    Family::new(
        "layer-soft",
        CONTRAST,
        Cube(Shape::Layer),
        "A layer along the cells, a million times as soft.",
    )
    .with(&["material.inclusion.shear_modulus=1e-6"]),
    Family::new(
        "ball-stiff",
        CONTRAST,
        Cube(Shape::Ball),
        "A ball across the cells, a million times as stiff.",
    )
    .with(&["material.inclusion.shear_modulus=1e6"]),
    Family::new(
        "ball-soft",
        CONTRAST,
        Cube(Shape::Ball),
        "A ball across the cells, a million times as soft.",
    )
    .with(&["material.inclusion.shear_modulus=1e-6"]),
    Family::new(
        "stokes-cylinder",
        include_str!("../examples/stokes-cylinder.toml"),
        Gmsh("cylinder"),
        "Viscous flow through a plane channel around a cylinder.",
    ),
    Family::new(
        "stokes-obstacle",
        include_str!("../examples/stokes-obstacle.toml"),
        Gmsh("ball"),
        "Viscous flow through a channel around a ball.",
    ),
];

/// A family by name.
///
/// # Errors
/// A message that names all of them.
pub(crate) fn find(name: &str) -> Result<&'static Family, String> {
    let found = FAMILIES.iter().find(|family| family.name == name);
    found.ok_or_else(|| {
        let names: Vec<_> = FAMILIES.iter().map(|family| family.name).collect();
        format!("known: {}", names.join(", "))
    })
}
