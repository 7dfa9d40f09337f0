//! Meshes that the server refines until goals are known as well as a scene asks.

use signorini_proto::v1;
use signorini_proto::v1::refine_mesh_response::Part;

use super::connect::{Client, answer};
use super::error::ClientError;
use super::mesh::missing;

/// Whether a scene asks for a mesh that is fine enough for its goals.
pub fn is_asked(scene: &v1::Scene) -> bool {
    let accuracy = scene.accuracy.as_ref();
    accuracy.is_some_and(|accuracy| !accuracy.targets.is_empty())
}

impl Client {
    /// The scene on a mesh that is fine enough for its goals; the same where it asks for none.
    ///
    /// # Errors
    /// As [`Client::refine_mesh`].
    pub async fn fine_enough(&self, scene: v1::Scene) -> Result<v1::Scene, ClientError> {
        if !is_asked(&scene) {
            return Ok(scene);
        }
        let refined = self.refine_mesh(scene, |_| ()).await?;
        refined
            .scene
            .ok_or_else(|| missing("the scene of a refined mesh"))
    }

    /// Refines the mesh of a scene with `accuracy.targets`, whose arrays the server has; calls
    /// `told` with what each mesh gave. The answer has the scene for a session on the refined mesh.
    /// The work ends where the future is dropped.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: as for a plan, `MEMORY_BUDGET`, `REFINEMENT_FAILED` where the
    /// mesh of the scene cannot be prepared. [`ClientError::Protocol`] for a stream that ends
    /// before its last message.
    pub async fn refine_mesh(
        &self,
        scene: v1::Scene,
        mut told: impl FnMut(v1::RefinementRound),
    ) -> Result<v1::RefinedMesh, ClientError> {
        let request = v1::RefineMeshRequest { scene: Some(scene) };
        let mut stream = answer(self.meshes().refine_mesh(request))
            .await?
            .into_inner();
        while let Some(message) = stream.message().await? {
            match message.part {
                Some(Part::Round(round)) => told(round),
                Some(Part::Refined(refined)) => return Ok(refined),
                // The call is alive.
                None => {}
            }
        }
        let lacks = "the stream of a refinement ended before its last message";
        Err(ClientError::Protocol(lacks.to_owned()))
    }
}
