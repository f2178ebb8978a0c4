//! Error type for invalid input.

/// An invalid input. The message names the argument, its problem, and the expected value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{argument}: {problem}")]
pub struct GeometryError {
    /// Name of the invalid argument, as the caller knows it.
    pub argument: String,
    /// Problem and expected value.
    pub problem: String,
}

impl GeometryError {
    /// Error for `argument`.
    pub fn new(argument: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { argument: argument.into(), problem: problem.into() }
    }
}

/// Result of an operation that checks its input.
pub type Result<T> = std::result::Result<T, GeometryError>;
