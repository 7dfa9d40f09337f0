//! SHA-256 of a scene: of all of it that a later bit of a field or report depends on,
//! which leaves out its name and its limit of time.
//!
//! Every list, text and optional value follows its count, u64 little-endian; numbers go
//! by their bits, choices by their names in scenes. Every struct is taken apart whole,
//! so that a new key of the scene cannot be forgotten here.

use sha2::{Digest, Sha256};

use crate::obstacle::grid::Lattice;
use crate::obstacle::surface::{Interpolation, SurfaceShape};

use crate::scene::{
    ContactPair, Fluid, FluidThreshold, Formulation, Material, MaterialModel, Modulus, Obstacle,
    Pressure, Probe, Profile, RubberModel, Scene, SceneKind, Shape, SolverOptions, Support,
    SupportLoad, SurfaceGeometry, Tie, ToleranceRule, Traction, Values,
};

/// The digest of `scene`.
pub(super) fn of(scene: &Scene) -> [u8; 32] {
    let mut hash = Canonical(Sha256::new());
    hash.scene(scene);
    hash.0.finalize().into()
}

/// Takes parts of a scene up, one after the other.
struct Canonical(Sha256);

impl Canonical {
    fn length(&mut self, length: usize) {
        self.0.update((length as u64).to_le_bytes());
    }

    fn numbers(&mut self, values: &[f64]) {
        self.length(values.len());
        for value in values {
            self.0.update(value.to_le_bytes());
        }
    }

    fn optional(&mut self, value: Option<f64>) {
        self.numbers(value.as_slice());
    }

    fn text(&mut self, text: &str) {
        self.length(text.len());
        self.0.update(text.as_bytes());
    }

    fn texts(&mut self, texts: &[String]) {
        self.all(texts, |hash, text| hash.text(text));
    }

    fn all<T>(&mut self, items: &[T], each: impl Fn(&mut Self, &T)) {
        self.length(items.len());
        items.iter().for_each(|item| each(self, item));
    }

    fn scene(&mut self, scene: &Scene) {
        let Scene {
            name: _,
            mesh_scale,
            kind,
            materials,
            supports,
            tractions,
            pressures,
            fluids,
            body_force,
            body_force_values,
            obstacles,
            contacts,
            ties,
            manufactured,
            probes,
            // Changes no state.
            questions: _,
            solver,
        } = scene;
        self.optional(*mesh_scale);
        self.text(kind.map_or("", SceneKind::name));
        self.all(materials, Self::material);
        self.all(supports, Self::support);
        self.all(tractions, Self::traction);
        self.all(pressures, Self::pressure);
        self.numbers(body_force);
        self.values(body_force_values.as_ref());
        self.all(obstacles, Self::obstacle);
        self.text(manufactured.as_deref().unwrap_or_default());
        self.all(probes, Self::probe);
        self.solver(solver);
        // A scene without fluids has the digest that it had before there were any.
        if !fluids.is_empty() {
            self.all(fluids, Self::fluid);
        }
        if !contacts.is_empty() {
            self.text("contact");
            self.all(contacts, Self::contact);
        }
        if !ties.is_empty() {
            self.text("tie");
            self.all(ties, Self::tie);
        }
    }

    fn tie(&mut self, tie: &Tie) {
        let Tie {
            name,
            between,
            carries,
        } = tie;
        self.text(name);
        self.texts(between);
        self.text(carries.as_deref().unwrap_or_default());
    }

    fn contact(&mut self, contact: &ContactPair) {
        let ContactPair {
            name,
            between,
            carries,
            friction,
            tresca,
        } = contact;
        self.text(name);
        self.texts(between);
        self.text(carries.as_deref().unwrap_or_default());
        if *friction != 0.0 || tresca.is_some() {
            self.text("friction");
            self.numbers(&[*friction]);
            self.optional(*tresca);
        }
    }

    fn fluid(&mut self, fluid: &Fluid) {
        let Fluid {
            name,
            on,
            from,
            dry,
            pressure,
            threshold,
            film,
            blow_off_tolerance,
            viscosity,
        } = fluid;
        self.text(name);
        for groups in [on, from, dry] {
            self.texts(groups);
        }
        self.optional(match threshold {
            FluidThreshold::Fluid => None,
            FluidThreshold::Pressure(pressure) => Some(*pressure),
        });
        self.text(film.name());
        self.numbers(&[*pressure, *blow_off_tolerance]);
        // A fluid without a viscosity has the digest that it had before there was one.
        if viscosity.is_some() {
            self.optional(*viscosity);
        }
    }

    fn material(&mut self, material: &Material) {
        let Material { group, model } = material;
        self.text(group);
        self.text(model.name());
        let formulation = match model {
            MaterialModel::LinearElastic {
                modulus,
                poisson_ratio,
                formulation,
            } => {
                self.modulus(*modulus);
                self.numbers(&[*poisson_ratio]);
                formulation
            }
            MaterialModel::Stokes {
                viscosity,
                formulation,
            } => {
                self.numbers(&[*viscosity]);
                formulation
            }
            MaterialModel::Rubber {
                model,
                bulk_modulus,
                formulation,
            } => {
                self.rubber(model);
                self.optional(*bulk_modulus);
                formulation
            }
        };
        self.text(match formulation {
            Formulation::Auto => "auto",
            Formulation::Mixed => "mixed",
            Formulation::Displacement => "displacement",
        });
    }

    fn modulus(&mut self, modulus: Modulus) {
        let (name, value) = match modulus {
            Modulus::Shear(value) => ("shear", value),
            Modulus::Young(value) => ("young", value),
        };
        self.text(name);
        self.numbers(&[value]);
    }

    fn rubber(&mut self, model: &RubberModel) {
        match model {
            RubberModel::MooneyRivlin { c10, c01 } => self.numbers(&[*c10, *c01]),
            RubberModel::NeoHookean { shear_modulus } => self.numbers(&[*shear_modulus]),
            RubberModel::Yeoh { c10, c20, c30 } => self.numbers(&[*c10, *c20, *c30]),
            RubberModel::Ogden { mu, alpha } => {
                self.numbers(mu);
                self.numbers(alpha);
            }
            RubberModel::Polynomial { coefficients } => self.numbers(coefficients),
            RubberModel::Gent {
                shear_modulus,
                limit,
            } => self.numbers(&[*shear_modulus, *limit]),
            RubberModel::ArrudaBoyce {
                mu,
                locking_stretch,
            } => self.numbers(&[*mu, *locking_stretch]),
            RubberModel::VanDerWaals {
                shear_modulus,
                locking_stretch,
                a,
                beta,
            } => self.numbers(&[*shear_modulus, *locking_stretch, *a, *beta]),
            RubberModel::Hyperfoam { mu, alpha, nu } => {
                [mu, alpha, nu]
                    .into_iter()
                    .for_each(|all| self.numbers(all));
            }
            RubberModel::BlatzKo { shear_modulus } => self.numbers(&[*shear_modulus]),
        }
    }

    fn support(&mut self, support: &Support) {
        let Support {
            name,
            on,
            displacement,
            normal,
            profile,
            values,
            load,
        } = support;
        self.text(name);
        self.texts(on);
        displacement.iter().for_each(|value| self.optional(*value));
        self.optional(*normal);
        self.text(match profile {
            Profile::Constant => "constant",
            Profile::Parabolic => "parabolic",
        });
        self.values(values.as_ref());
        if *load != SupportLoad::default() {
            self.text("load");
            let all = [load.components(), load.springs()];
            all.as_flattened()
                .iter()
                .for_each(|one| self.optional(*one));
            self.numbers(&load.about.unwrap_or_default());
        }
    }

    fn traction(&mut self, traction: &Traction) {
        let Traction {
            name,
            on,
            value,
            values,
        } = traction;
        self.texts(on);
        self.numbers(value);
        if let Some(name) = name {
            self.text("name");
            self.text(name);
        }
        self.values(values.as_ref());
    }

    fn values(&mut self, values: Option<&Values>) {
        let Some(Values {
            place,
            numbers,
            rows,
        }) = values
        else {
            return;
        };
        self.text("values");
        self.text(place.name());
        self.length(numbers.len());
        for number in numbers {
            self.0.update(number.to_le_bytes());
        }
        self.numbers(rows.as_flattened());
    }

    fn pressure(&mut self, pressure: &Pressure) {
        let Pressure { on, value } = pressure;
        self.texts(on);
        self.numbers(&[*value]);
    }

    fn obstacle(&mut self, obstacle: &Obstacle) {
        let Obstacle {
            name,
            on,
            shape,
            surface,
            friction,
            tresca,
            // What is refused has no state.
            initial_penetration: _,
        } = obstacle;
        if *friction != 0.0 || tresca.is_some() {
            self.text("friction");
            self.numbers(&[*friction]);
            self.optional(*tresca);
        }
        if *surface == SurfaceGeometry::Smooth {
            self.text("smooth");
        }
        self.text(name);
        self.texts(on);
        self.shape(shape);
    }

    fn shape(&mut self, shape: &Shape) {
        let none = &[0.0; 3];
        let (kind, [first, second], numbers): (_, [&[f64; 3]; 2], Vec<f64>) = match shape {
            Shape::HalfSpace { point, normal } => ("half-space", [point, normal], vec![]),
            Shape::Sphere { centre, radius } => ("sphere", [centre, none], vec![*radius]),
            Shape::Cylinder {
                point,
                axis,
                radius,
            } => ("cylinder", [point, axis], vec![*radius]),
            Shape::CappedCylinder {
                from,
                to,
                radius,
                rounding,
            } => ("capped-cylinder", [from, to], vec![*radius, *rounding]),
            Shape::Box {
                centre,
                half_sizes,
                rounding,
            } => ("box", [centre, half_sizes], vec![*rounding]),
            Shape::Torus {
                centre,
                axis,
                radius,
                tube_radius,
            } => ("torus", [centre, axis], vec![*radius, *tube_radius]),
            Shape::Cone {
                apex,
                axis,
                angle,
                rounding,
            } => ("cone", [apex, axis], vec![*angle, *rounding]),
            Shape::Surface(shape) => return self.surface(shape),
            Shape::HeightField(grid) => {
                return self.grid("height-field", grid.lattice(), grid.coefficients());
            }
            Shape::DistanceGrid(grid) => {
                return self.grid("distance-grid", grid.lattice(), grid.coefficients());
            }
            Shape::Cavity(of) => {
                self.text("cavity");
                return self.shape(of);
            }
        };
        self.text(kind);
        self.numbers(first);
        self.numbers(second);
        match numbers[..] {
            [] => self.optional(None),
            [radius] => self.optional(Some(radius)),
            _ => self.numbers(&numbers),
        }
    }

    fn surface(&mut self, shape: &SurfaceShape) {
        self.text("surface");
        let between = match shape.between {
            Interpolation::Facets => 0.0,
            Interpolation::Patches(angle) => angle,
        };
        self.numbers(&[shape.scale, between]);
        self.numbers(shape.surface.vertices().as_flattened());
        for facet in shape.surface.facets() {
            self.numbers(&facet.map(f64::from));
        }
    }

    fn grid<const N: usize>(&mut self, kind: &str, lattice: &Lattice<N>, values: &[f64]) {
        let Lattice {
            counts,
            origin,
            spacing,
        } = lattice;
        self.text(kind);
        counts.iter().for_each(|count| self.length(*count));
        self.numbers(origin);
        self.numbers(spacing);
        self.numbers(values);
    }

    fn probe(&mut self, probe: &Probe) {
        let Probe { name, point } = probe;
        self.text(name);
        self.numbers(point);
    }

    fn solver(&mut self, solver: &SolverOptions) {
        let SolverOptions {
            tolerance,
            tolerance_rule,
            error_estimate,
            quadrature_degree,
            max_wall_time: _,
            element,
            displacement_preconditioner,
            p1_solver,
            saddle,
            contact,
            contact_metric,
            contact_space,
            stability,
            on_instability,
            response,
            report,
            penalty,
            verify,
        } = solver;
        self.numbers(&[*tolerance]);
        self.text(match tolerance_rule {
            ToleranceRule::Fixed => "fixed",
            ToleranceRule::Discretisation => "discretisation",
        });
        let methods = [
            error_estimate.name(),
            element.name(),
            displacement_preconditioner.name(),
            p1_solver.name(),
            saddle.name(),
            contact.name(),
            contact_metric.name(),
            contact_space.name(),
            stability.name(),
            on_instability.name(),
        ];
        methods.into_iter().for_each(|method| self.text(method));
        // Said only where it is asked for: checkpoints from before it was there keep their digest.
        if response.named().is_some() {
            self.text(response.name());
        }
        if report.named().is_some() {
            self.text(report.name());
        }
        self.optional(quadrature_degree.map(f64::from));
        self.optional(*penalty);
        self.text(if *verify { "verify" } else { "" });
    }
}
