//! A scene and a model from their bytes.

use super::ModelPackage;

/// Decodes a [`ModelPackage`]; `None` where the bytes are not one, or more than one.
pub fn decode(bytes: &[u8]) -> Option<ModelPackage> {
    let (package, rest) = postcard::take_from_bytes(bytes).ok()?;
    rest.is_empty().then_some(package)
}
