//! Scenes of the tests that an independent solver has digits of.

/// A scene of the tests with its mesh, by name.
macro_rules! of_tests {
    ($name:literal) => {
        (
            $name,
            include_str!(concat!("../../families/", $name, ".toml")),
            include_bytes!(concat!("../../families/", $name, ".msh")),
        )
    };
}

/// Scenes of the tests that an independent solver has digits of: the scene file, which names
/// its mesh as the row, and the mesh.
pub(super) const OF_TESTS: &[(&str, &str, &[u8])] = &[
    of_tests!("7-0002-clamped-sides"),
    of_tests!("7-0029-indenter"),
    of_tests!("7-0035-five-clamped"),
    of_tests!("7-0038-five-clamped"),
    of_tests!("7-0047-roller-box"),
    of_tests!("7-0060-far-wall"),
    of_tests!("7-0088-halves"),
    of_tests!("7-0097-groove"),
];

/// The mesh of a scene of the tests.
pub(super) fn mesh_of_tests(name: &str) -> Option<&'static [u8]> {
    let found = OF_TESTS.iter().find(|scene| scene.0 == name);
    found.map(|scene| scene.2)
}
