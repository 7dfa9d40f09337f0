//! Families of scenes: one scene file, meshes of increasing size.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use serde_json::Value;

use crate::shaped::Shape;

/// What an error is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Quantity {
    /// Displacement, in L2.
    DisplacementL2,
    /// Gradient of the displacement, in L2.
    DisplacementH1,
    /// Pressure, in L2.
    PressureL2,
    /// Strain energy of the whole body.
    StrainEnergy,
    /// Force of the obstacle on the whole body, along its motion.
    Force,
    /// Its part across the motion along z: what friction carries. On a body that is made of
    /// mirrored models it cancels out; there it is that many times the part on the model.
    TangentialForce,
    /// Largest contact pressure.
    ContactPressure,
    /// Radius of the disc of the whole contact area.
    ContactRadius,
}

impl Quantity {
    /// All of them, in the order of the columns.
    pub(crate) const ALL: [Self; 8] = [
        Self::DisplacementL2,
        Self::DisplacementH1,
        Self::PressureL2,
        Self::StrainEnergy,
        Self::Force,
        Self::TangentialForce,
        Self::ContactPressure,
        Self::ContactRadius,
    ];

    /// As columns and files spell it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::DisplacementL2 => "displacement_l2",
            Self::DisplacementH1 => "displacement_h1",
            Self::PressureL2 => "pressure_l2",
            Self::StrainEnergy => "strain_energy",
            Self::Force => "force",
            Self::TangentialForce => "tangential_force",
            Self::ContactPressure => "contact_pressure",
            Self::ContactRadius => "contact_radius",
        }
    }

    /// As figures spell it.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::DisplacementL2 => "displacement (L2 norm)",
            Self::DisplacementH1 => "displacement gradient (H1 seminorm)",
            Self::PressureL2 => "pressure (L2 norm)",
            Self::StrainEnergy => "strain energy",
            Self::Force => "contact force",
            Self::TangentialForce => "tangential contact force",
            Self::ContactPressure => "largest contact pressure",
            Self::ContactRadius => "contact radius",
        }
    }

    /// The error is known from the run itself: it needs no limit. The number is
    /// the norm of the exact field A1m that the error is divided by.
    pub(crate) fn exact_norm(self) -> Option<f64> {
        match self {
            Self::DisplacementL2 => Some(1.220_536_6),
            Self::DisplacementH1 => Some(5.373_791_9),
            Self::PressureL2 => Some(0.235_702_3),
            Self::StrainEnergy
            | Self::Force
            | Self::TangentialForce
            | Self::ContactPressure
            | Self::ContactRadius => None,
        }
    }

    /// Its value in a `step` line: the error norm for fields, else of the whole
    /// body, `whole_body` times that of the model.
    pub(crate) fn read(self, step: &Value, whole_body: f64) -> Option<f64> {
        let error = |name: &str| step.pointer(&format!("/errors/{name}"))?.as_f64();
        let obstacle = || step.get("obstacles")?.as_object()?.values().next();
        let force = |axis: &str| obstacle()?.pointer(&format!("/force/{axis}"))?.as_f64();
        match self {
            Self::DisplacementL2 | Self::DisplacementH1 | Self::PressureL2 => error(self.name()),
            Self::StrainEnergy => Some(step.get("strain_energy")?.as_f64()? * whole_body),
            Self::Force => Some(force("2")?.abs() * whole_body),
            Self::TangentialForce => Some(force("0")?.hypot(force("1")?) * whole_body),
            Self::ContactPressure => obstacle()?.get("max_pressure")?.as_f64(),
            Self::ContactRadius => {
                let area = obstacle()?.get("contact_area")?.as_f64()? * whole_body;
                Some((area / PI).sqrt())
            }
        }
    }
}

/// A member of a family: `n16` for 16 cells an edge, `l3` for a Gmsh mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Level {
    /// `n` or `l`.
    pub(crate) letter: char,
    /// 1 to 99.
    pub(crate) number: u32,
}

impl fmt::Display for Level {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}{}", self.letter, self.number)
    }
}

impl FromStr for Level {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "n1 to n99 (cells an edge) or l1 to l9 (Gmsh meshes)".to_owned();
        let mut characters = text.chars();
        let letter = characters.next().ok_or_else(expected)?;
        let number = characters.as_str().parse().map_err(|_| expected())?;
        match (letter, number) {
            ('n', 1..=99) | ('l', 1..=9) => Ok(Self { letter, number }),
            _ => Err(expected()),
        }
    }
}

/// Where the meshes of a family come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshSource {
    /// Written by [`crate::cube`], in a shape of [`crate::shaped`].
    Cube(Shape),
    /// Files with this prefix.
    Gmsh(&'static str),
}

impl MeshSource {
    /// The letter of its levels.
    pub(crate) fn letter(self) -> char {
        match self {
            Self::Cube(_) => 'n',
            Self::Gmsh(_) => 'l',
        }
    }
}

/// A scene and its meshes.
#[derive(Debug)]
pub(crate) struct Family {
    /// As `--scene` takes it.
    pub(crate) name: &'static str,
    /// One sentence for readers.
    pub(crate) about: &'static str,
    /// The scene file.
    pub(crate) scene: &'static str,
    /// Meshes.
    pub(crate) source: MeshSource,
    /// Levels of its chapter in a full run; none for scenes that only studies use.
    pub(crate) full: &'static [u32],
    /// The same in a quick run.
    pub(crate) quick: &'static [u32],
    /// Methods of its chapter.
    pub(crate) methods: &'static [&'static str],
    /// Changes of the scene file.
    pub(crate) settings: &'static [&'static str],
    /// How many times the model fills the whole body.
    pub(crate) whole_body: f64,
    /// What its errors are measured in.
    pub(crate) quantities: &'static [Quantity],
}

impl Family {
    /// For studies only, of a whole body.
    pub(crate) const fn new(
        name: &'static str,
        scene: &'static str,
        source: MeshSource,
        about: &'static str,
    ) -> Self {
        Self {
            name,
            about,
            scene,
            source,
            full: &[],
            quick: &[],
            methods: &["auto"],
            settings: &[],
            whole_body: 1.0,
            quantities: &[],
        }
    }

    /// Name of the first obstacle of its scene; empty without one.
    pub(crate) fn obstacle(&self) -> String {
        let scene = self.scene.parse::<toml::Table>().unwrap_or_default();
        let name = || {
            Some(
                scene
                    .get("obstacle")?
                    .get(0)?
                    .get("name")?
                    .as_str()?
                    .to_owned(),
            )
        };
        name().unwrap_or_default()
    }

    /// With changes of the scene file.
    pub(crate) const fn with(mut self, settings: &'static [&'static str]) -> Self {
        self.settings = settings;
        self
    }

    /// With these methods in its chapter.
    pub(crate) const fn by(mut self, methods: &'static [&'static str]) -> Self {
        self.methods = methods;
        self
    }

    /// The model is a quarter of the body.
    pub(crate) const fn of_a_quarter(mut self) -> Self {
        self.whole_body = 4.0;
        self
    }

    /// With a chapter of its own: levels of a full and of a quick run, and what
    /// the errors are measured in.
    pub(crate) const fn measured(
        mut self,
        full: &'static [u32],
        quick: &'static [u32],
        quantities: &'static [Quantity],
    ) -> Self {
        (self.full, self.quick, self.quantities) = (full, quick, quantities);
        self
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn levels_are_read_as_they_are_printed() {
        for text in ["n6", "n34", "l5"] {
            assert_eq!(text.parse::<Level>().unwrap().to_string(), text);
        }
        for text in ["", "6", "n", "n0", "n100", "l10", "x3"] {
            assert!(text.parse::<Level>().is_err(), "{text}");
        }
    }

    #[test]
    fn quarter_models_are_counted_four_times() {
        let step = json!({
            "strain_energy": 0.5,
            "obstacles": {"ball": {"force": [1.0, 2.0, -3.0], "max_pressure": 7.0, "contact_area": PI}},
            "errors": null,
        });
        let read = |quantity: Quantity| quantity.read(&step, 4.0);
        assert_eq!(read(Quantity::StrainEnergy), Some(2.0));
        assert_eq!(read(Quantity::Force), Some(12.0));
        let tangential = read(Quantity::TangentialForce).unwrap();
        assert!((tangential - 4.0 * 5.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(read(Quantity::ContactPressure), Some(7.0));
        assert_eq!(read(Quantity::ContactRadius), Some(2.0));
        assert_eq!(read(Quantity::PressureL2), None);
    }
}
