//! The type of the result of a command.

use crate::error::Error;

/// The output of a command, which is not empty even where a part of the command failed, and its
/// result.
pub type Report = (String, Result<(), Error>);
