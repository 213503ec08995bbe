//! Findings: conclusions about the inputs.

use serde::Serialize;

/// A conclusion about an input, with its evidence and the flag that would force it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Subject of the conclusion: a role, the camera, the space of the normals.
    pub subject: String,
    /// The conclusion.
    pub conclusion: String,
    /// Why.
    pub evidence: String,
    /// The flag that would force it.
    pub flag: String,
}

/// Conclusions and warnings gathered while loading.
pub(super) struct Notes {
    pub(super) findings: Vec<Finding>,
    pub(super) warnings: Vec<String>,
}
