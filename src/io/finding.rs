//! Findings: conclusions about the inputs.

use serde::Serialize;

/// What was concluded about an input, from what evidence, and the flag that would force it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What the conclusion is about: a role, the camera, the space of the normals.
    pub subject: String,
    /// The conclusion.
    pub conclusion: String,
    /// Why.
    pub evidence: String,
    /// The flag that would force it.
    pub flag: String,
}
