//! Writes a PVD file: a time series of VTU and VTP files for ParaView.

use std::fmt::Write as _;

use super::vtk_xml::escape;

/// One file of the series.
#[derive(Clone, Debug, PartialEq)]
pub struct PvdEntry {
    /// Time at which it is shown.
    pub time: f64,
    /// Part of the scene: 0 the body, then the obstacles.
    pub part: usize,
    /// Path relative to the PVD file.
    pub file: String,
}

/// The text of a PVD file.
pub fn write(entries: &[PvdEntry]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for entry in entries {
        let (time, part, file) = (entry.time, entry.part, escape(&entry.file));
        // Writing to a string cannot fail.
        let _infallible = writeln!(
            text,
            "<DataSet timestep=\"{time}\" part=\"{part}\" file=\"{file}\"/>"
        );
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_carry_time_part_and_escaped_file() {
        let entry = PvdEntry {
            time: 0.5,
            part: 1,
            file: "a&b.vtp".into(),
        };
        let text = write(&[entry]);
        assert!(text.contains("<DataSet timestep=\"0.5\" part=\"1\" file=\"a&amp;b.vtp\"/>"));
        assert!(text.ends_with("</VTKFile>\n"));
    }
}
