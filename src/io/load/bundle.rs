//! Files that belong together: a folder as estimators of normals and depth write one, or a NumPy archive of several arrays.
//!
//! Names tell which is what; see [`NAMES`].

use super::opened::Opened;
use crate::error::{Error, Result};
use crate::io::inputs::Inputs;
use crate::io::open::files_in;
use crate::io::photo::pictures_in;
use crate::io::roles::Role;
use crate::io::text::is_one_of;
use crate::untrusted::{listed, shown};
use std::borrow::Cow;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Files or arrays by their roles.
pub(crate) struct RoleBundle {
    path: PathBuf,
    members: Vec<(Role, PathBuf)>,
    camera: Option<PathBuf>,
    /// Those without a role.
    left_out: Vec<PathBuf>,
}

/// Roles by the words of names. A name with several is the first of these: `image_depth` is depth.
const NAMES: [(Role, &str); 5] = [
    (Role::Coverage, "mask valid"),
    (Role::Normal, "normal normals"),
    (Role::Depth, "depth disparity"),
    (Role::Position, "points point pts pts3d position positions"),
    (
        Role::Color,
        "image img rgb color colour photo input picture",
    ),
];

/// Words of names of what is made to be looked at, and of what a frame does not have.
const NOT_DATA: &str =
    "vis viz visualization preview colored coloured colorized confidence conf uncertainty";

/// Endings of files that are read, those of floats first.
const FLOATS: &str = "exr npy pfm";
const CODES: &str = "png jpg jpeg tif tiff webp tga bmp hdr pgm ppm pnm";

/// Names of files that hold a camera.
const CAMERAS: &str = "fov.json camera.json";

impl RoleBundle {
    /// What stands at `path`; `None` for a single file.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where names leave open what is what; [`Error::Io`].
    pub(crate) fn of(path: &Path) -> Result<Option<Self>> {
        if path.is_dir() {
            return Self::of_folder(path).map(Some);
        }
        let is_archive = path.extension().is_some_and(|own| is_one(own, "npz"));
        match is_archive.then(|| pictures_in(path)).transpose()?.flatten() {
            Some(arrays) if arrays.len() > 1 => Self::named(path, arrays, None).map(Some),
            _ => Ok(None),
        }
    }

    fn of_folder(path: &Path) -> Result<Self> {
        let mut files = files_in(path)?;
        let is_camera = |file: &&PathBuf| file.file_name().is_some_and(|own| is_one(own, CAMERAS));
        let cameras: Vec<_> = files.iter().filter(is_camera).cloned().collect();
        if cameras.len() > 1 {
            return Err(ambiguous(path, "camera", &cameras));
        }
        let is_read = |file: &PathBuf| {
            let ending = file.extension();
            ending.is_some_and(|own| is_one(own, FLOATS) || is_one(own, CODES)) && file.is_file()
        };
        files.retain(is_read);
        Self::named(path, files, cameras.into_iter().next())
    }

    /// Gives each role to the file that is called so. One picture that is called otherwise is the image, where there is
    /// none, or the normals by its numbers.
    fn named(path: &Path, mut files: Vec<PathBuf>, camera: Option<PathBuf>) -> Result<Self> {
        files.retain(|file| !words(file).any(|word| is_one_of(&word, NOT_DATA)));
        let mut members = Vec::new();
        for (role, names) in NAMES {
            let is_it = |file: &PathBuf| words(file).any(|word| is_one_of(&word, names));
            let (mut found, rest) = files.into_iter().partition(is_it);
            files = rest;
            keep_floats(&mut found);
            match &found[..] {
                [] => {}
                [file] => members.push((role, file.clone())),
                _ => return Err(ambiguous(path, &role.name(), &found)),
            }
        }
        let mut bundle = Self {
            path: path.into(),
            members,
            camera,
            left_out: files,
        };
        if bundle.member(Role::Color).is_none() {
            bundle.take_unnamed()?;
        }
        match bundle.members.iter().any(|(role, _)| shows(*role)) {
            true => Ok(bundle),
            false => Err(bundle.refused()),
        }
    }

    fn take_unnamed(&mut self) -> Result<()> {
        let [file] = &self.left_out[..] else {
            return match self.left_out.len() {
                0 => Ok(()),
                _ if self.members.is_empty() => Err(self.refused()),
                _ => Err(ambiguous(&self.path, &Role::Color.name(), &self.left_out)),
            };
        };
        let is_map = Opened::open(file)?.is_normal_map();
        let role = match is_map && self.member(Role::Normal).is_none() {
            true => Role::Normal,
            false => Role::Color,
        };
        self.members.push((role, file.clone()));
        self.left_out.clear();
        Ok(())
    }

    /// The file of a role.
    pub(crate) fn member(&self, role: Role) -> Option<&Path> {
        let mut members = self.members.iter();
        members.find_map(|(own, file)| (*own == role).then_some(file.as_path()))
    }

    /// The image, or else what is shown by another.
    pub(crate) fn picture(&self) -> Option<&Path> {
        let mut members = self.members.iter().filter(|(role, _)| shows(*role));
        let first = members.next().map(|(_, file)| file.as_path());
        self.member(Role::Color).or(first)
    }

    /// `inputs` of a picture that is this bundle, with its files for all roles that are not given.
    pub(crate) fn inputs(&self, inputs: &Inputs) -> Inputs {
        let mut inputs = inputs.clone();
        let given = |role| self.member(role).map(|file| file.display().to_string());
        inputs.picture = self.picture().map(PathBuf::from).unwrap_or_default();
        let has_image = self.member(Role::Color).is_some();
        let no_picture = (!has_image).then(|| Inputs::NONE.into());
        let has_depth = self.member(Role::Depth).is_some() || inputs.depth.is_some();
        for (own, found) in [
            (&mut inputs.color, no_picture),
            (&mut inputs.normal, given(Role::Normal)),
            (&mut inputs.depth, given(Role::Depth)),
            (&mut inputs.coverage, given(Role::Coverage)),
            (
                &mut inputs.position,
                given(Role::Position).filter(|_| !has_depth),
            ),
        ] {
            *own = own.take().or(found);
        }
        // Positions tell how the camera is turned as well.
        let camera = self.camera.clone().filter(|_| inputs.position.is_none());
        inputs.camera = inputs.camera.take().or(camera);
        inputs
    }

    /// What is taken for what, in one line.
    pub(crate) fn note(&self, inputs: &Inputs) -> String {
        let is_used = |(role, file): &&(Role, PathBuf)| {
            let named = match role {
                Role::Normal => &inputs.normal,
                Role::Depth => &inputs.depth,
                Role::Position => &inputs.position,
                Role::Coverage => &inputs.coverage,
                _ => return inputs.color.is_none(),
            };
            named.as_deref().map(Path::new) == Some(file)
        };
        let members = self.members.iter().filter(is_used);
        let taken =
            members.map(|(role, file)| format!("{} as {}", shown_name(file), called(*role)));
        let camera = self
            .camera
            .iter()
            .filter(|own| inputs.camera.as_ref() == Some(*own));
        let taken = taken.chain(camera.map(|file| format!("{} as camera", shown_name(file))));
        let taken = taken.collect::<Vec<_>>().join(", ");
        let unused = self.members.iter().filter(|member| !is_used(member));
        let unused = unused.map(|(_, file)| file).chain(&self.left_out);
        match &shown_names(unused)[..] {
            "" => format!("taken: {taken}"),
            unused => format!("taken: {taken}; left out: {unused}"),
        }
    }

    /// The error where it has nothing for a role.
    pub(crate) fn without(&self, role: Role) -> Error {
        let files = self.members.iter().map(|(_, file)| file);
        let found = shown_names(files.chain(&self.left_out));
        Error::MissingAov {
            path: self.path.clone(),
            found: format!("has no {} by name (found {found})", role.name()),
            remedy: format!("name one of them with --{}", role.name()),
        }
    }

    fn refused(&self) -> Error {
        let found = match &self.left_out[..] {
            [] => "nothing that is read".into(),
            files => shown_names(files),
        };
        Error::Unsupported {
            path: self.path.clone(),
            found: format!("holds no image, normal, depth or points by name (found {found})"),
            remedy: "name a file".into(),
        }
    }
}

/// `inputs` of a single picture as they are, those of a bundle with its files, and what is said of it.
pub(crate) fn gathered(inputs: &Inputs) -> Result<(Cow<'_, Inputs>, Option<String>)> {
    Ok(match RoleBundle::of(&inputs.picture)? {
        None => (Cow::Borrowed(inputs), None),
        Some(bundle) => {
            let inputs = bundle.inputs(inputs);
            let note = bundle.note(&inputs);
            (Cow::Owned(inputs), Some(note))
        }
    })
}

/// Whether a role can be the picture that others stand beside.
fn shows(role: Role) -> bool {
    role != Role::Coverage
}

/// A role, in the words of messages.
fn called(role: Role) -> String {
    match role {
        Role::Color => "image".into(),
        Role::Normal => "normals".into(),
        Role::Position => "points".into(),
        Role::Coverage => "mask".into(),
        other => other.name(),
    }
}

fn is_one(name: &OsStr, all: &str) -> bool {
    all.split_whitespace()
        .any(|own| name.eq_ignore_ascii_case(own))
}

/// The words of a file's name, in lower case.
fn words(file: &Path) -> impl Iterator<Item = String> {
    let stem = file.file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy().to_ascii_lowercase();
    let words = stem.split(|c: char| !c.is_ascii_alphanumeric());
    words.map(String::from).collect::<Vec<_>>().into_iter()
}

/// Of files that are called the same, keeps the one with floats.
fn keep_floats(files: &mut Vec<PathBuf>) {
    let are_one = files
        .windows(2)
        .all(|pair| pair[0].file_stem() == pair[1].file_stem());
    let is_float = |file: &PathBuf| file.extension().is_some_and(|own| is_one(own, FLOATS));
    if are_one && files.iter().filter(|file| is_float(file)).count() == 1 {
        files.retain(is_float);
    }
}

fn shown_name(file: &Path) -> String {
    shown(Path::new(file.file_name().unwrap_or_default()))
}

fn shown_names<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> String {
    let names: Vec<_> = files.into_iter().map(|file| shown_name(file)).collect();
    listed(&names)
}

fn ambiguous(path: &Path, role: &str, found: &[PathBuf]) -> Error {
    Error::Unsupported {
        path: path.into(),
        found: format!("has several for {role} ({})", shown_names(found)),
        remedy: format!("name the picture itself, and one of them with --{role} FILE"),
    }
}
