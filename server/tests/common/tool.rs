//! Tools that are uploaded: closed triangles, heights, signed distances.

use signorini_proto::array;
use signorini_proto::digest::{grid_digest, hex, surface_digest};
use signorini_proto::v1::{self as wire, upload_surface_request::Part};

/// Of the tools that are round.
const RADIUS: f64 = 2.0;
/// Between the nodes of grids, from -1 to 2.
const SPACING: f64 = 0.25;
const NODES: usize = 13;

/// What touches the top of a block of height one from above.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tool {
    Plate,
    Cap,
    Ball,
}

impl Tool {
    pub(crate) const ALL: [Self; 3] = [Self::Plate, Self::Cap, Self::Ball];

    pub(crate) fn messages(self) -> Vec<wire::UploadSurfaceRequest> {
        let parts = match self {
            Self::Plate => plate(),
            Self::Cap => grid(2, |x| {
                1.0 + (squared(x[0]) + squared(x[1])) / (2.0 * RADIUS)
            }),
            Self::Ball => grid(3, |x| {
                let height = x[2] - 1.0 - RADIUS;
                (squared(x[0]) + squared(x[1]) + height * height).sqrt() - RADIUS
            }),
        };
        let request = |part| wire::UploadSurfaceRequest { part: Some(part) };
        parts.into_iter().map(request).collect()
    }

    /// `surfaces/{digest}`.
    pub(crate) fn name(self) -> String {
        let (mut coordinates, mut facets, mut values, mut grid) = (vec![], vec![], vec![], None);
        for message in self.messages() {
            match message.part.unwrap() {
                Part::Header(header) => grid = header.grid,
                Part::Chunk(chunk) => match chunk.array() {
                    wire::SurfaceArray::Coordinates => {
                        coordinates = array::decode(&chunk.data).unwrap();
                    }
                    wire::SurfaceArray::Facets => facets = array::decode(&chunk.data).unwrap(),
                    _ => values = array::decode(&chunk.data).unwrap(),
                },
            }
        }
        let digest = match grid {
            Some(grid) => {
                let counts: Vec<usize> = grid.counts.iter().map(|one| *one as usize).collect();
                grid_digest(&counts, (&grid.origin, &grid.spacing), &values)
            }
            None => surface_digest(&coordinates, &facets),
        };
        format!("surfaces/{}", hex(&digest))
    }

    /// The shape whose upload has that name.
    pub(crate) fn shape(self, name: String) -> wire::Shape {
        use wire::shape::Kind;
        let kind = match self {
            Self::Plate => Kind::Surface(wire::SurfaceShape {
                surface: name,
                ..Default::default()
            }),
            Self::Cap => Kind::HeightField(wire::HeightField { grid: name }),
            Self::Ball => Kind::DistanceGrid(wire::DistanceGrid { grid: name }),
        };
        wire::Shape {
            kind: Some(kind),
            inside: matches!(self, Self::Cap),
        }
    }
}

/// Of the distance to the middle of the block.
fn squared(x: f64) -> f64 {
    (x - 0.5) * (x - 0.5)
}

fn chunk(array: wire::SurfaceArray, data: bytes::Bytes) -> Part {
    Part::Chunk(wire::SurfaceChunk {
        array: array.into(),
        offset_elements: 0,
        data,
    })
}

/// A flat box, wider than the block.
fn plate() -> Vec<Part> {
    let corner = |index: i32| {
        let far = |bit: i32| index & bit != 0;
        let along = |bit: i32| if far(bit) { 2.0 } else { -1.0 };
        [along(1), along(2), if far(4) { 2.0 } else { 1.0 }]
    };
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let facets: Vec<i32> = (sides.iter())
        .flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d])
        .collect();
    let corners: Vec<f64> = (0..8).flat_map(corner).collect();
    let header = wire::SurfaceHeader {
        vertex_count: 8,
        facet_count: 12,
        ..Default::default()
    };
    vec![
        Part::Header(header),
        chunk(wire::SurfaceArray::Coordinates, array::encode(&corners)),
        chunk(wire::SurfaceArray::Facets, array::encode(&facets)),
    ]
}

/// Values at the nodes of a grid from -1 to 2 along each axis.
fn grid(axes: usize, of: impl Fn(&[f64]) -> f64) -> Vec<Part> {
    let mut values = Vec::new();
    for index in 0..NODES.pow(axes as u32) {
        let (mut rest, mut place) = (index, vec![0.0; axes]);
        for along in place.iter_mut().rev() {
            *along = -1.0 + (rest % NODES) as f64 * SPACING;
            rest /= NODES;
        }
        values.push(of(&place));
    }
    let grid = wire::Grid {
        counts: vec![NODES as i64; axes],
        origin: vec![-1.0; axes],
        spacing: vec![SPACING; axes],
    };
    let header = wire::SurfaceHeader {
        grid: Some(grid),
        ..Default::default()
    };
    vec![
        Part::Header(header),
        chunk(wire::SurfaceArray::Values, array::encode(&values)),
    ]
}
