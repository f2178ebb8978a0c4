//! What can be wrong with an input.

/// A refused input. The message names the argument and what was expected of it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{argument}: {problem}")]
pub struct GeometryError {
    /// Name of the argument at fault, as the caller knows it.
    pub argument: String,
    /// What is wrong with it, and what was expected.
    pub problem: String,
}

impl GeometryError {
    /// Builds the error for `argument`.
    pub fn new(argument: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { argument: argument.into(), problem: problem.into() }
    }
}

/// Result of an operation that may refuse its input.
pub type Result<T> = std::result::Result<T, GeometryError>;
