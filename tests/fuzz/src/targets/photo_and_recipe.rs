//! Any bytes as a photo, and any text as a recipe.

use relievo::cli::recipe::Recipe;
use relievo::io::photo::Photo;
use std::io::Write;
use std::path::Path;

pub(super) fn run(data: &[u8]) {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = Recipe::parse(Path::new("look.toml"), text);
        let settings = format!("version = 1\ncommand = \"relight\"\n{text}");
        let _ = Recipe::parse(Path::new("look.toml"), &settings);
    }
    let mut file = tempfile::NamedTempFile::new().expect("room for a file");
    file.write_all(data).expect("room for a file");
    if let Ok(photo) = Photo::read(file.path()) {
        let _ = photo.to_linear();
    }
}
