//! The house as `docs/ARCHITECTURE.md` draws it: imports between rooms go down.

use std::path::{Path, PathBuf};

/// Rooms from the ground up. Those of one floor know nothing of each other.
const FLOORS: &str = "kernel product srgb large_blocks untrusted / error / params / frame / gpu trace / plan / shape / light
    / line scenes / stages / engine io / command / work / report view / cli / host main";

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn imports_between_rooms_go_down() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let floors = || FLOORS.split('/').map(str::split_whitespace);
    let floor = |room: &str| floors().position(|mut rooms| rooms.any(|own| own == room));
    let mut all = Vec::new();
    files(&src, &mut all);
    let mut seen = 0;
    for path in all {
        let own = path.strip_prefix(&src).unwrap();
        let room = own.iter().next().unwrap().to_str().unwrap();
        let room = room.trim_end_matches(".rs");
        if room == "lib" {
            continue;
        }
        let here = floor(room).unwrap_or_else(|| panic!("{room} has no floor"));
        let text = std::fs::read_to_string(&path).unwrap();
        // Tests at the end of a file may use all that is there; a link in a comment is no import.
        let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
        let lines = code
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        for import in lines.flat_map(|line| line.split("crate::").skip(1)) {
            let end = import.find(|c: char| !c.is_alphanumeric() && c != '_');
            let other = &import[..end.unwrap_or(import.len())];
            let Some(there) = floor(other).filter(|_| other != room) else {
                continue;
            };
            assert!(there < here, "{} imports {other}", own.display());
            seen += 1;
        }
    }
    assert!(seen > 1000, "{seen} imports");
}
