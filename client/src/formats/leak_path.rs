//! The path on which a fluid leaks first, as a line for ParaView.
//!
//! VTK XML `PolyData` with one polyline through the points of the path, and the pressure between
//! body and obstacles at each: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.
//! Points `[points][3]` and pressures `[points]` in the caller's units.

use super::vtk_xml::{Notes, Writer};

/// Name of the values at the points.
pub const PRESSURE: &str = "pressure";

/// The bytes of a VTP file; points without a pressure of their own have none, and are left out.
pub fn write(points: &[[f64; 3]], pressures: &[f64], notes: &Notes) -> Vec<u8> {
    let count = points.len().min(pressures.len());
    let places: Vec<f64> = points.iter().take(count).flatten().copied().collect();
    let values: Vec<f64> = pressures.iter().take(count).copied().collect();
    let mut file = Writer::new("PolyData");
    file.line("<PolyData>");
    file.notes(notes);
    file.line(&format!(
        "<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"0\" NumberOfLines=\"1\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">"
    ));
    file.line(&format!("<PointData Scalars=\"{PRESSURE}\">"));
    file.array(PRESSURE, 1, &values);
    file.line("</PointData>");
    file.line("<Points>");
    file.array("Points", 3, &places);
    file.line("</Points>");
    file.line("<Lines>");
    file.array("connectivity", 1, &(0..count as i64).collect::<Vec<i64>>());
    file.array("offsets", 1, &[count as i64]);
    file.line("</Lines>");
    file.line("</Piece>");
    file.finish("PolyData")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_one_line_through_its_points_with_the_pressure_at_each() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0]];
        let text = write(&points, &[0.5, 3.0, 0.0], &Notes::default());
        let text = String::from_utf8_lossy(&text).into_owned();
        for part in [
            "NumberOfPoints=\"3\"",
            "NumberOfLines=\"1\"",
            "<PointData Scalars=\"pressure\">",
            "Name=\"offsets\"",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        let short = write(&points, &[0.5], &Notes::default());
        assert!(String::from_utf8_lossy(&short).contains("NumberOfPoints=\"1\""));
    }
}
