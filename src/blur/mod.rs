//! Hand-drawn motion blur of an animated mesh (Sakai: Motion Blur for 3DCG Animation with Hand Drawing Style).
//!
//! A post effect: from the mesh's poses and the frames already rendered, each output smears the mesh along the
//! trajectories of its vertices, in ragged teeth, and colours it from both frames.

pub mod mesh;
pub mod motion;
#[doc(hidden)]
pub mod reference;
pub mod settings;

pub use mesh::{Mesh, MeshInput};
pub use motion::{Cluster, Interval, Motion, Pose, Window};
pub use settings::Settings;
