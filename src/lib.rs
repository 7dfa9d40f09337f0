//! placeholder
pub mod assembly;
pub mod contact;
pub mod element;
pub mod geometry;
pub mod inequality;
pub mod krylov;
pub mod linalg;
pub mod material;
pub mod mesh;
pub mod obstacle;
pub mod plan;
pub mod precond;
pub mod report;
pub mod saddle;
pub mod scene;
pub mod space;
pub mod sqp;

pub use mesh::{CellKind, Group, GroupKind, Mesh, MeshError, MeshId, MeshParts};
pub use plan::{LeftOut, Plan, PlanEntry, PlanReport, PrepareError, Prepared, PreparedKey};
pub use report::{
    CancelToken, Cause, FieldData, FieldName, IterationRecord, Observer, Residuals, Silent,
    StepReport, Termination,
};
pub use scene::{Scene, SceneError, Step, Violation};
pub use sqp::{ObstaclePose, Reuse, Session, StepRun};
