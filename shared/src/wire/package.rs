//! A scene and a model from their bytes.

use super::ModelPackage;
use crate::model::Scene;

/// Decodes a [`ModelPackage`]; `None` where the bytes are not one, or more than one.
pub fn decode(bytes: &[u8]) -> Option<ModelPackage> {
    decode_in_parts(bytes).map(|(package, _)| package)
}

/// The same, and how many of the bytes are the scene's: they come first, and scenes of the same bytes are the same.
pub fn decode_in_parts(bytes: &[u8]) -> Option<(ModelPackage, usize)> {
    let (scene, after): (Scene<f32>, _) = postcard::take_from_bytes(bytes).ok()?;
    let ((model, limits), rest) = postcard::take_from_bytes(after).ok()?;
    rest.is_empty().then(|| ((scene, model, limits), bytes.len() - after.len()))
}
