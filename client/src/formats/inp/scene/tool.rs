//! Analytical surfaces of rigid bodies: a line or an arc, swept along an axis or turned about it.
//!
//! ```text
//! TYPE=SEGMENTS               in the plane z = 0
//! TYPE=CYLINDER  a, b, c      x from a to b, swept from a to c, which is against z
//! TYPE=REVOLUTION  a, b       r from the axis a b, z along it
//! START, x, y   LINE, x, y   CIRCL, x, y, centre x, centre y
//! ```
//!
//! Within an instance a cylinder may leave its points out: its axes are those of the instance,
//! which moves and turns all of these.

use super::super::cards::{Data, Keyword, text};
use super::super::error::InpError;
use super::super::fields::{finite, points};
use super::super::frame::Frame;
use super::Reader;

type Point = [f64; 3];

/// Differences over a length that are those of the digits of a file.
const SAME: f64 = 1e-6;

/// What a surface is where the body meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// A plane through a point; which side is free the deck says by the way of its line, the
    /// caller by where the body is.
    Plane {
        /// A point of it.
        point: Point,
        /// Across it, of either sign; not of unit length.
        normal: Point,
    },
    /// A cylinder, in the plane a disc.
    Cylinder {
        /// A point of its axis.
        point: Point,
        /// Along its axis.
        axis: Point,
        /// Length.
        radius: f64,
    },
    /// A ball.
    Sphere {
        /// Its middle.
        centre: Point,
        /// Length.
        radius: f64,
    },
}

/// A rigid surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Name of the surface.
    pub name: String,
    /// What stands for it.
    pub profile: Profile,
    /// The node that moves it, or its set, in capitals.
    pub reference: Option<String>,
}

/// Parts of a profile: lines by their ends, arcs by their centre.
#[derive(Clone, Copy)]
enum Part {
    Line([f64; 2], [f64; 2]),
    Arc { centre: [f64; 2], radius: f64 },
}

impl<'a> Reader<'a> {
    pub(super) fn surface(&mut self, keyword: &Keyword) -> Result<(), InpError> {
        let kind = keyword
            .value("TYPE")
            .unwrap_or_default()
            .to_ascii_uppercase();
        if !["SEGMENTS", "CYLINDER", "REVOLUTION"].contains(&kind.as_str()) {
            return Ok(());
        }
        let frame = match kind.as_str() {
            "SEGMENTS" => Some(Frame::default()),
            _ => self.axes(keyword, &kind)?,
        };
        let parts = self.parts(keyword)?;
        let name = self.own(keyword.value("NAME").unwrap_or_default());
        let Some(frame) = frame else {
            let why = "without points of its axes that lie apart";
            self.leave_out(keyword, why);
            return Ok(());
        };
        let outer = self.instance.as_ref().map(|(_, frame)| *frame);
        let frame = frame.within(&outer.unwrap_or_default());
        match profile(&frame, &kind, &parts) {
            Some(profile) => self.scene.tools.push(Tool { name, profile, reference: None }),
            None => self.leave_out(keyword, "a profile other than one line or arcs about one centre: triangulate it to an STL file"),
        }
        Ok(())
    }

    /// The local system: of a cylinder its x and y; of a revolution x across and y along the axis.
    fn axes(&mut self, keyword: &Keyword, kind: &str) -> Result<Option<Frame>, InpError> {
        let is_cylinder = kind == "CYLINDER";
        let unsaid = Ok(Some(Frame::default()).filter(|_| is_cylinder));
        let Some(data) = self.axis_line().filter(|data| !data.fields.is_empty()) else {
            self.axis_line();
            return unsaid;
        };
        let [a, b] = points(keyword, &data)?;
        if is_cylinder {
            let Some(data) = self.axis_line() else {
                return Ok(None);
            };
            let [c, _] = points(keyword, &data)?;
            return Ok(Frame::swept(a, b, c));
        }
        let beside = |axis: Point| [a[0] + axis[0], a[1] + axis[1], a[2] + axis[2]];
        let tries = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(beside);
        // The axis first, then turned so that it is the second one.
        let along = tries.iter().find_map(|plane| Frame::through(a, b, *plane));
        Ok(along.and_then(|along| Frame::through(a, along.place([0.0, 1.0, 0.0]), b)))
    }

    /// A name as the assembly has it: with the instance that is being read.
    fn own(&self, name: &str) -> String {
        match &self.instance {
            Some((instance, _)) => format!("{instance}.{name}"),
            None => name.to_owned(),
        }
    }

    /// Sets of one node name reference points.
    pub(super) fn node_set(&mut self, keyword: &Keyword) {
        let Some(name) = keyword.value("NSET") else {
            return;
        };
        let name = self.own(name).to_ascii_uppercase();
        let is_node = keyword.name == "NODE";
        while let Some(data) = self.cards.data() {
            let is_one = is_node || (data.fields.len() == 1 && !keyword.has("GENERATE"));
            let field = data.fields.first().filter(|_| is_one);
            let member = field.map(|field| match keyword.value("INSTANCE") {
                Some(instance) => format!("{instance}.{}", text(field)),
                None => self.own(&text(field)),
            });
            let member = member.map(|member| member.to_ascii_uppercase());
            self.single
                .entry(name.clone())
                .and_modify(|known| *known = None)
                .or_insert(member);
        }
    }

    pub(super) fn rigid_body(&mut self, keyword: &Keyword) {
        let surface = keyword.value("ANALYTICAL SURFACE");
        match surface.zip(keyword.value("REF NODE")) {
            Some((surface, node)) => {
                let surface = self.own(surface).to_ascii_uppercase();
                let node = self.own(node);
                self.references.insert(surface, node);
            }
            None => self.leave_out(
                keyword,
                "without an analytical surface and a reference node",
            ),
        }
    }

    /// A line with points of the axes; none where the profile begins.
    fn axis_line(&mut self) -> Option<Data<'a>> {
        if self.cards.begins_with(b"START") {
            return None;
        }
        self.cards.data()
    }

    fn parts(&mut self, keyword: &Keyword) -> Result<Vec<Part>, InpError> {
        let mut parts = Vec::new();
        let mut at = [0.0; 2];
        while let Some(data) = self.cards.data() {
            let mut fields = data.fields.iter();
            let word = text(fields.next().copied().unwrap_or_default()).to_ascii_uppercase();
            let mut numbers = [0.0; 4];
            for (slot, field) in numbers.iter_mut().zip(fields) {
                *slot = finite(keyword, data.line, field)?;
            }
            let [x, y, u, v] = numbers;
            match word.as_str() {
                "LINE" => parts.push(Part::Line(at, [x, y])),
                "CIRCL" => parts.push(Part::Arc {
                    centre: [u, v],
                    radius: (x - u).hypot(y - v),
                }),
                _ => {}
            }
            at = [x, y];
        }
        Ok(parts)
    }
}

/// What stands for a profile; none where nothing does.
fn profile(frame: &Frame, kind: &str, parts: &[Part]) -> Option<Profile> {
    let turned = kind == "REVOLUTION";
    let place = |[x, y]: [f64; 2], z: f64| frame.place([x, y, z]);
    let towards = |from: Point, to: Point| [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    match *parts {
        [Part::Line(a, b)] => {
            let normal = [a[1] - b[1], b[0] - a[0]];
            let size = normal;
            // Turned about its axis, a line across it is a plane, one along it a cylinder.
            let (is_across, is_along) = (is_near(a[1], b[1], size), is_near(a[0], b[0], size));
            match (turned, is_across, is_along) {
                (true, false, true) => Some(Profile::Cylinder {
                    point: place([0.0, a[1]], 0.0),
                    axis: towards(place([0.0; 2], 0.0), place([0.0, 1.0], 0.0)),
                    radius: a[0].abs(),
                }),
                (true, false, false) | (_, true, true) => None,
                _ => Some(Profile::Plane {
                    point: place(a, 0.0),
                    normal: towards(place([0.0; 2], 0.0), place(normal, 0.0)),
                }),
            }
        }
        [Part::Arc { centre, radius }, ref others @ ..] => {
            let alike = |part: &Part| {
                let Part::Arc {
                    centre: other,
                    radius: size,
                } = *part
                else {
                    return false;
                };
                let scale = [radius, radius];
                let at = centre.iter().zip(other).all(|(a, b)| is_near(*a, b, scale));
                at && is_near(size, radius, scale)
            };
            let is_whole = others.iter().all(alike) && radius > 0.0;
            match (is_whole, turned, centre[0] == 0.0) {
                (true, true, true) => Some(Profile::Sphere {
                    centre: place(centre, 0.0),
                    radius,
                }),
                (true, false, _) => Some(Profile::Cylinder {
                    point: place(centre, 0.0),
                    axis: towards(place(centre, 0.0), place(centre, 1.0)),
                    radius,
                }),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Whether two numbers are one beside a length, given by its components.
fn is_near(a: f64, b: f64, [x, y]: [f64; 2]) -> bool {
    (a - b).abs() <= SAME * x.hypot(y)
}
