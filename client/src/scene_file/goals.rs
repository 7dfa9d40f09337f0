//! What is asked of goals: derivatives and errors.

use signorini_proto::v1;

use super::keys::Keys;

pub(super) fn gradients(scene: &Keys<'_>) -> Vec<v1::Gradient> {
    let tables = scene.tables("gradient", &["of", "to"]);
    let gradient = |keys: &Keys<'_>| v1::Gradient {
        of: keys.required_names("of"),
        to: keys.required_names("to"),
    };
    tables.iter().map(gradient).collect()
}

pub(super) fn accuracy(scene: &Keys<'_>) -> Option<v1::Accuracy> {
    let keys = scene.table("accuracy", &["bound"])?;
    Some(v1::Accuracy {
        bound: keys.names("bound"),
    })
}
