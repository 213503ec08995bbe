//! Any bytes as an HDR, TIFF, PNG or JPEG picture, wherever a picture is read: an error or a picture.

use relievo::io::inputs::Inputs;
use relievo::io::{Needs, load, read_environment, read_lit_sphere, survey};

/// Reads `data` as an environment, a lit sphere, and a picture with itself as its normal map.
pub(super) fn run(data: &[u8]) {
    let file = tempfile::NamedTempFile::new().expect("room for a file");
    let path = file.path();
    std::fs::write(path, data).expect("room for a file");
    let _ = read_environment(path);
    let _ = read_lit_sphere(path);
    let inputs = Inputs {
        picture: path.into(),
        normal: Some(path.display().to_string()),
        ..Inputs::default()
    };
    let _ = survey(&inputs);
    let needs = Needs {
        color: true,
        ..Needs::default()
    };
    let _ = load(&inputs, needs);
}
