//! Scenes of callers who solve in their own process, by the same rules as those of requests.

use signorini::scene::{Scene, SceneError, Step, Violation};
use signorini_proto::v1 as wire;
use wire::upload_surface_request::Part;

use super::scene::scene;
use super::surface::{Upload, name};
use super::uploaded::SurfacesByName;
use crate::fault::Fault;

/// A scene and its steps as the library takes them; one default step where there is none. Each of
/// `surfaces` is the messages of an upload.
///
/// # Errors
/// What a server refuses of the scene or of a surface.
pub fn scene_and_steps(
    message: wire::Scene,
    surfaces: Vec<Vec<wire::UploadSurfaceRequest>>,
) -> Result<(Scene, Vec<Step>), SceneError> {
    let mut by_name = SurfacesByName::new();
    for messages in surfaces {
        let whole = uploaded(messages).map_err(refused)?;
        by_name.insert(name(&whole.digest), whole.surface().map_err(refused)?);
    }
    let request = scene(message, &by_name).map_err(refused)?;
    let (scene, mut steps) = request.into_parts().map_err(refused)?;
    if steps.is_empty() {
        steps.push(Step::default());
    }
    Ok((scene, steps))
}

fn uploaded(messages: Vec<wire::UploadSurfaceRequest>) -> Result<super::surface::Whole, Fault> {
    let mut parts = messages.into_iter().filter_map(|message| message.part);
    let Some(Part::Header(header)) = parts.next() else {
        return Err(Fault::request("header", "must be the first message"));
    };
    let mut upload = Upload::new(header)?;
    for part in parts {
        match part {
            Part::Chunk(chunk) => upload.push(&chunk)?,
            Part::Header(_) => {
                return Err(Fault::request("header", "must be the first message only"));
            }
        }
    }
    upload.finish()
}

fn refused(fault: Fault) -> SceneError {
    let message = fault.to_string();
    if let Fault::SceneInvalid(faults) = fault {
        SceneError::Invalid(faults)
    } else if let Fault::Unsupported(one) = fault {
        SceneError::Unsupported(one)
    } else if let Fault::RequestInvalid(one) = fault {
        SceneError::Invalid(vec![one])
    } else {
        let path = "scene".to_owned();
        SceneError::Invalid(vec![Violation { path, message }])
    }
}
