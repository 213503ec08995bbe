//! A folder of small files to run command lines in, with the invariants to check after each.

use image::{DynamicImage, ImageFormat};
use relievo::frame::{Plane, Window};
use relievo::io::exr::{
    ChannelId, ExrFile, Limits, OutputChannel, OutputCompression, OutputPart, OutputType,
    write_results,
};
use relievo::io::output::is_whole;
use relievo::io::photo::Photo;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io::Cursor;
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard};

/// The size of every picture that is no environment: wide enough for all stages, and quick.
const SIZE: [usize; 2] = [24, 18];

/// The file whose bytes come with the command line.
const EXTRA: &str = "extra";

/// A thing on the desk.
#[derive(Debug, Clone, PartialEq)]
enum Thing {
    File(Vec<u8>),
    Folder,
    Link(PathBuf),
    Pipe,
    /// Something else, or nothing.
    Other,
}

/// The folder. It is the current one during a run, so that paths are relative as a user types them.
pub(super) struct Desk {
    folder: PathBuf,
    things: BTreeMap<PathBuf, Thing>,
}

static DESK: LazyLock<Mutex<Desk>> = LazyLock::new(|| Mutex::new(Desk::new()));

impl Desk {
    /// The only desk of this process, since there is one current folder.
    pub(super) fn shared() -> MutexGuard<'static, Self> {
        DESK.lock().expect("no run has failed before")
    }

    fn new() -> Self {
        let folder = std::env::temp_dir().join(format!("relievo-desk-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("room for a folder");
        Self {
            folder,
            things: things(),
        }
    }

    /// Runs a command line and checks the files it leaves.
    pub(super) fn run(&self, words: &[&[u8]], extra: &[u8]) {
        // A report takes seconds at least, and help ignores everything else.
        let left_out = [&b"report"[..], b"--help", b"--help-all", b"-h"];
        let is_run = |word: &&[u8]| stays_here(word) && !left_out.contains(word);
        if !words.iter().all(is_run) {
            return;
        }
        // The runner of the target has relative paths too.
        let home = std::env::current_dir().expect("there is a current folder");
        std::env::set_current_dir(&self.folder).expect("the folder is there");
        self.tidy();
        fs::write(EXTRA, extra).expect("room for a file");
        let named = Named::by(words);
        let program = [&b"relievo"[..]];
        let line = program.iter().chain(words);
        let code = relievo::cli::run_words(line.map(|word| OsString::from_vec(word.to_vec())));
        assert!((0..=3).contains(&code), "exit code {code}");
        let twice = code == 0 && named.writes_twice();
        assert!(!twice, "two outputs in one file");
        let given = (PathBuf::from(EXTRA), Thing::File(extra.to_vec()));
        for (path, thing) in self.things.iter().chain([(&given.0, &given.1)]) {
            let input = named.inputs.iter().any(|input| path.starts_with(input));
            assert!(!input || look(path) == *thing, "{path:?} was written over");
        }
        let [_, recipe, timings] = &named.outputs;
        for path in all_in(Path::new(".")) {
            let is_new = self.things.get(&path) != Some(&look(&path));
            // These two may have any name.
            let is_text = [recipe, timings].contains(&&Some(path.clone()));
            if is_new && path != given.0 && !is_text {
                // Inputs are as they were. Large ones take seconds to look through, and few runs make an output.
                check_output(&path, code == 0 && !named.holds_infinities());
            }
        }
        std::env::set_current_dir(home).expect("it was there before");
    }

    /// Puts everything back as it was.
    fn tidy(&self) {
        for path in all_in(Path::new(".")).iter().rev() {
            if self.things.get(path) != Some(&look(path)) {
                let _ = fs::remove_file(path);
                let _ = fs::remove_dir(path);
            }
        }
        for (path, thing) in &self.things {
            if look(path) != *thing {
                thing.put(path);
            }
        }
    }
}

impl Thing {
    fn put(&self, path: &Path) {
        match self {
            Self::File(bytes) => fs::write(path, bytes).expect("room for a file"),
            Self::Folder => fs::create_dir(path).expect("room for a folder"),
            Self::Link(target) => symlink(target, path).expect("room for a link"),
            Self::Pipe => {
                let mode = rustix::fs::Mode::from_raw_mode(0o600);
                rustix::fs::mkfifoat(rustix::fs::CWD, path, mode).expect("room for a pipe");
            }
            Self::Other => {}
        }
    }
}

/// The thing at `path`.
fn look(path: &Path) -> Thing {
    let Ok(kind) = fs::symlink_metadata(path).map(|data| data.file_type()) else {
        return Thing::Other;
    };
    match () {
        () if kind.is_file() => fs::read(path).map_or(Thing::Other, Thing::File),
        () if kind.is_dir() => Thing::Folder,
        () if kind.is_symlink() => fs::read_link(path).map_or(Thing::Other, Thing::Link),
        () if kind.is_fifo() => Thing::Pipe,
        () => Thing::Other,
    }
}

/// Everything in `folder`, folders before their content.
fn all_in(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let path = path.strip_prefix(".").unwrap_or(&path).to_path_buf();
        all.push(path.clone());
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            all.extend(all_in(&path));
        }
    }
    all
}

/// Whether a word names nothing outside the desk: no absolute path, even joined to a flag, and at most one `..`.
fn stays_here(word: &[u8]) -> bool {
    let text = String::from_utf8_lossy(word).replace("sub/../", "sub/");
    let is_short_flag = text.starts_with('-') && !text.starts_with("--");
    let slashes = text.match_indices('/');
    let after_name = |at: usize| {
        let before = text[..at].chars().next_back();
        before.is_some_and(|c| c.is_ascii_alphanumeric() || "._#".contains(c))
    };
    let inside = slashes.into_iter().all(|(at, _)| after_name(at));
    !text.contains("..") && inside && !(is_short_flag && text.contains('/'))
}

/// The flags whose values are written, in all spellings.
const WRITTEN: [&[&str]; 3] = [&["-o", "--output"], &["--save-recipe"], &["--timings"]];

/// Files named by a command line.
#[derive(Default)]
struct Named {
    /// Files and folders that may be read, if they are on the desk.
    inputs: Vec<PathBuf>,
    /// The file for each of [`WRITTEN`], the last one if there are several.
    outputs: [Option<PathBuf>; WRITTEN.len()],
}

impl Named {
    fn by(words: &[&[u8]]) -> Self {
        let mut named = Self::default();
        let mut words = words.iter().map(|word| String::from_utf8_lossy(word));
        while let Some(word) = words.next() {
            let (flag, value) = match word.split_once('=') {
                Some((flag, value)) => (flag, Some(value)),
                None if word.starts_with("-o") && word.len() > 2 => ("-o", Some(&word[2..])),
                None => (&*word, None),
            };
            match WRITTEN.iter().position(|flags| flags.contains(&flag)) {
                Some(kind) => {
                    let value = value.map(PathBuf::from);
                    let next = || words.next().map(|word| PathBuf::from(&*word));
                    named.outputs[kind] = value.or_else(next);
                }
                None => {
                    let names = value.unwrap_or(&word).split(',');
                    named.inputs.extend(names.flat_map(on_the_desk));
                }
            }
        }
        named
    }

    /// Whether two outputs are one file.
    fn writes_twice(&self) -> bool {
        let places: Vec<_> = self.outputs.iter().flatten().map(|p| place(p)).collect();
        (1..places.len()).any(|n| places[..n].contains(&places[n]))
    }

    /// Whether an input has samples that are not finite.
    fn holds_infinities(&self) -> bool {
        let inputs = self.inputs.iter();
        let mut planes = inputs.flat_map(|path| samples(path).unwrap_or_default());
        planes.any(|plane| !is_finite(&plane))
    }
}

/// The actual or future path of a file, without links and detours.
fn place(path: &Path) -> PathBuf {
    // Of a bare name the folder is empty.
    let folder = Path::new(".").join(path.parent().unwrap_or(Path::new("")));
    let folder = fs::canonicalize(folder).unwrap_or_default();
    fs::canonicalize(path).unwrap_or_else(|_| folder.join(path.file_name().unwrap_or_default()))
}

/// The things on the desk named by `name`: one, or all of a sequence.
fn on_the_desk(name: &str) -> Vec<PathBuf> {
    if name.contains('#') || name.contains("%0") {
        let mut all = all_in(Path::new("."));
        all.retain(|path| path.to_string_lossy().starts_with("shot."));
        return all;
    }
    let here = fs::canonicalize(".").expect("the desk is there");
    let found = fs::canonicalize(name).ok().filter(|path| *path != here);
    let inside = found.and_then(|path| path.strip_prefix(&here).ok().map(Path::to_path_buf));
    inside.into_iter().collect()
}

fn is_finite(plane: &Plane) -> bool {
    plane.samples().iter().all(|v| v.is_finite())
}

/// The samples of a picture.
fn samples(path: &Path) -> relievo::Result<Vec<Plane>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    if !fs::read(path).is_ok_and(|bytes| bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])) {
        let photo = Photo::read(path)?;
        return Ok(photo.channels.into_iter().chain(photo.alpha).collect());
    }
    let file = ExrFile::open(path, &Limits::default())?;
    let ids: Vec<ChannelId> = file.channel_ids().collect();
    file.read_channels(&ids)
}

/// Checks a file that a run has made.
fn check_output(path: &Path, finite: bool) {
    let name = path.to_string_lossy().to_lowercase();
    assert!(!name.ends_with(".part"), "{path:?} is left");
    // Recipes and timings may be written under any name.
    let is_text = |bytes: Vec<u8>| bytes.starts_with(b"version = ") || bytes.starts_with(b"{");
    if !path.is_file() || fs::read(path).is_ok_and(is_text) {
        return;
    }
    assert!(is_whole(path), "{path:?} is not whole");
    let known = [".exr", ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".hdr"];
    if known.iter().any(|end| name.ends_with(end)) {
        let planes = samples(path).unwrap_or_else(|error| panic!("{error}"));
        let all_finite = planes.iter().all(is_finite);
        assert!(!finite || all_finite, "{path:?} holds NaN or infinity");
    }
}

/// Content of the desk before every run.
fn things() -> BTreeMap<PathBuf, Thing> {
    let plain = picture("png", SIZE);
    let look = b"version = 1\ncommand = \"relight\"\nlight = \"135,40\"\n";
    let files: [(&[u8], Vec<u8>); 18] = [
        (b"frame.exr", frame(0)),
        (b"shot.0001.exr", frame(1)),
        (b"shot.0002.exr", frame(2)),
        (b"shot.0003.exr", frame(3)),
        (b"torn.exr", frame(0)[..frame(0).len() / 2].to_vec()),
        (b"spoiled.exr", exr(&["Z"], &spoiled)),
        (b"wild.exr", exr(&["A", "mask", "occ"], &wild)),
        (b"esc\x1b]0;x\x07.exr", frame(0)),
        (b"bytes\xff\xfe.exr", frame(0)),
        (b"plain.png", plain.clone()),
        (b"photo.jpg", picture("jpg", SIZE)),
        (b"scan.tif", picture("tif", SIZE)),
        (b"sky.hdr", picture("hdr", [16, 8])),
        (b"ball.png", picture("png", [16, 16])),
        (b"st/1.png", plain.clone()),
        (b"st/2.png", plain),
        (b"camera.json", b"{\"focal_px\": 30}".to_vec()),
        (b"look.toml", look.to_vec()),
    ];
    let files = files.map(|(name, bytes)| (OsString::from_vec(name.to_vec()), Thing::File(bytes)));
    let others = [
        ("st", Thing::Folder),
        ("sub", Thing::Folder),
        ("link.exr", Thing::Link("frame.exr".into())),
        ("astray.exr", Thing::Link("nowhere.exr".into())),
        ("pipe", Thing::Pipe),
    ];
    let others = others.map(|(name, thing)| (name.into(), thing));
    let all = files.into_iter().chain(others);
    all.map(|(name, thing)| (name.into(), thing)).collect()
}

/// A frame of bumps, `number` of a sequence.
fn frame(number: usize) -> Vec<u8> {
    // The height 2 cos(x / 4) cos(y / 4) has slopes of up to a half.
    let normal = |x: usize, y: usize| {
        let (x, y) = ((x + number) as f32 / 4.0, y as f32 / 4.0);
        let slope = [0.5 * x.sin() * y.cos(), -0.5 * x.cos() * y.sin()];
        let length = (slope[0] * slope[0] + slope[1] * slope[1] + 1.0).sqrt();
        [slope[0] / length, slope[1] / length, 1.0 / length]
    };
    exr(&["Z"], &|channel, x, y| match channel {
        "N.X" => normal(x, y)[0],
        "N.Y" => normal(x, y)[1],
        "N.Z" => normal(x, y)[2],
        "Z" => 5.0 + 0.01 * (x + y) as f32,
        _ => 0.8 * normal(x, y)[2],
    })
}

/// One sample in five that is not finite, in every layer.
fn spoiled(channel: &str, x: usize, y: usize) -> f32 {
    match (x + 3 * y + channel.len()) % 5 {
        0 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][(x + y) % 3],
        _ => 0.5,
    }
}

/// Coverage, and maps which are named by flags, far beyond 0 and 1.
fn wild(channel: &str, x: usize, y: usize) -> f32 {
    match channel {
        "A" | "mask" | "occ" if (x * y).is_multiple_of(5) => {
            [1e10, -1e30, 1e38, 65504.0, -0.5, 2.0][(x + 3 * y) % 6]
        }
        "A" | "mask" | "occ" => f32::from(u8::from(x > SIZE[0] / 3)),
        "N.X" | "N.Y" => 0.0,
        "N.Z" => 1.0,
        _ => 0.5,
    }
}

/// A frame with normals, a picture and these channels.
fn exr(more: &[&str], sample: &dyn Fn(&str, usize, usize) -> f32) -> Vec<u8> {
    let [width, height] = SIZE;
    let names = [&["R", "G", "B", "N.X", "N.Y", "N.Z"][..], more].concat();
    let plane = |n: &&str| Plane::from_fn(width, height, |x, y| sample(n, x, y));
    let planes: Vec<_> = names.iter().map(plane).collect();
    let channels = names.iter().zip(&planes);
    let channels = channels.map(|(name, plane)| OutputChannel {
        name: (*name).into(),
        plane,
        sample_type: OutputType::Float,
    });
    let part = OutputPart {
        name: "shot".into(),
        data_window: Window::from_size(width, height),
        display_window: Window::from_size(width, height),
        pixel_aspect: 1.0,
        channels: channels.collect(),
        attributes: Vec::new(),
        chromaticities: None,
        compression: OutputCompression::default(),
    };
    let mut file = Cursor::new(Vec::new());
    write_results(&mut file, Path::new("a frame"), &part).expect("a frame can be written");
    file.into_inner()
}

/// A small picture: normals that lean outward, so that it passes for a normal map too.
fn picture(extension: &str, [width, height]: [usize; 2]) -> Vec<u8> {
    let byte = |at: usize, of: usize| (96 + 64 * at / of) as u8;
    let pixel = |x: u32, y: u32| {
        let (x, y) = (x as usize, height - y as usize);
        image::Rgb([byte(x, width), byte(y, height), 240])
    };
    let picture = image::RgbImage::from_fn(width as u32, height as u32, pixel);
    let picture = DynamicImage::ImageRgb8(picture);
    let format = ImageFormat::from_extension(extension).expect("a known extension");
    let picture = match format {
        ImageFormat::Hdr => DynamicImage::ImageRgb32F(picture.to_rgb32f()),
        _ => picture,
    };
    let mut file = Cursor::new(Vec::new());
    let written = picture.write_to(&mut file, format);
    written.expect("a picture can be written");
    file.into_inner()
}
