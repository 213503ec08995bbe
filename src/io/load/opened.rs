//! Input files whose header has been read, and their companion files.

use crate::error::{Error, Result};
use crate::frame::Window;
use crate::io::exr::{self, ChannelId, ExrFile, Limits};
use crate::io::inputs::Inputs;
use crate::io::judge::map_codes::MapCodes;
use crate::io::judge::normal_encoding::holds_normals;
use crate::io::judge::numbers::{NUMBERED, RoleByNumbers, roles_by_numbers};
use crate::io::open::open_buffered;
use crate::io::photo::{PhotoHeader, StoredPhoto, is_inside};
use crate::io::roles::groups::{self, Groups};
use crate::io::roles::nearest;
use crate::io::roles::views;
use crate::io::roles::{self, Layer, Match, Role};
use crate::untrusted::listed;
use image::DynamicImage;
use std::cell::{OnceCell, RefCell};
use std::collections::HashMap;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::{Arc, OnceLock};

/// An input file whose header has been read: an EXR, or a photo, which has no layers.
pub(crate) struct Opened {
    pub(in crate::io) kind: OpenedKind,
    /// Its layers, of one view and one group if there are several.
    pub(crate) layers: Vec<Layer>,
    pub(crate) groups: Groups,
    /// All views, and the one in use.
    pub(crate) views: Vec<String>,
    pub(crate) view: Option<String>,
    /// The roles found by numbers, computed when first needed.
    by_numbers: OnceCell<Vec<RoleByNumbers>>,
    pub(crate) judged: Judged,
    /// Files opened as companions of this one.
    companions: RefCell<HashMap<PathBuf, Rc<Opened>>>,
    pub(crate) holding: Holding,
}

pub(in crate::io) enum OpenedKind {
    Exr(Box<ExrFile>),
    Photo(StoredPhoto),
}

/// What is found of a photo when it is first asked for.
#[derive(Debug, Clone, Default)]
pub(crate) struct Judged {
    /// Whether it is a normal map.
    is_normal_map: OnceLock<bool>,
    /// What its codes hold, if it is one.
    codes: OnceLock<MapCodes>,
    /// The noise of its slopes, if it is one.
    pub(crate) noise: OnceLock<f32>,
    bits_of_floats: OnceLock<Option<u8>>,
}

/// The view and the group whose layers are wanted; the default ones where none is named.
pub(crate) type Selection<'a> = [Option<&'a str>; 2];

/// Policy for holding the decoded samples of photos.
#[derive(Clone)]
pub(crate) struct Holding {
    /// Most bytes of samples of one photo: of others rows alone are read.
    pub(crate) most_bytes: u64,
    /// Whether they are kept for the next rows.
    pub(crate) stay: bool,
    /// Columns and rows of the cells that photos consist of, if they are sheets.
    pub(crate) cell: Option<[usize; 2]>,
    /// The part that is taken of photos, where these are decoded already.
    pub(crate) part: Option<PartOfPhotos>,
}

/// A part of photos that are decoded: it is read on any thread.
#[derive(Clone)]
pub(crate) struct PartOfPhotos {
    pub(crate) photos: Arc<Vec<WholePhoto>>,
    pub(crate) window: Window,
}

/// A decoded photo, and what was judged of the whole of it.
pub(crate) struct WholePhoto {
    header: PhotoHeader,
    samples: DynamicImage,
    judged: Judged,
}

impl Default for Holding {
    fn default() -> Self {
        Self {
            most_bytes: u64::MAX,
            stay: false,
            cell: None,
            part: None,
        }
    }
}

impl Holding {
    /// That of a photo of which at most `most_bytes` are decoded at a time: of a larger one rows are read.
    pub(crate) fn within(most_bytes: u64) -> Self {
        Self {
            most_bytes,
            ..Self::default()
        }
    }
}

impl PartOfPhotos {
    /// The part of the photo at `path`; `None` if it is not one of them.
    fn of(&self, path: &Path) -> Option<(StoredPhoto, Judged)> {
        let whole = self.photos.iter().find(|whole| whole.header.path == path)?;
        let part = StoredPhoto::part(&whole.header, &whole.samples, self.window);
        Some((part, whole.judged.clone()))
    }
}

impl Opened {
    pub(crate) fn open(path: &Path) -> Result<Rc<Self>> {
        Self::open_held(path, [None; 2], Holding::default())
    }

    /// The picture of `inputs`, with this policy for samples of photos.
    pub(crate) fn open_picture(inputs: &Inputs, holding: Holding) -> Result<Rc<Self>> {
        let wanted = [&inputs.view, &inputs.layer].map(Option::as_deref);
        Self::open_held(&inputs.picture, wanted, holding)
    }

    /// The file with the layers that are wanted, and the policy for samples of photos.
    pub(crate) fn open_held(
        path: &Path,
        [view, group]: Selection,
        holding: Holding,
    ) -> Result<Rc<Self>> {
        if let Some((photo, judged)) = holding.part.as_ref().and_then(|part| part.of(path)) {
            let part = Self::new(OpenedKind::Photo(photo), holding);
            return Ok(Rc::new(Self { judged, ..part }));
        }
        if is_inside(path) || !has_exr_magic(path)? {
            groups::refuse(group, path)?;
            let mut photo = StoredPhoto::open(path, holding.most_bytes)?;
            if let Some([width, height]) = holding.cell {
                photo.cell = [
                    width.min(photo.header.width),
                    height.min(photo.header.height),
                ];
            }
            return Ok(Rc::new(Self::new(OpenedKind::Photo(photo), holding)));
        }
        let file = Box::new(ExrFile::open(path, &Limits::default())?);
        let mut layers = layers_of(&file);
        let views = views::mark(&file, &mut layers);
        Ok(Rc::new(Self {
            view: views::keep(&file, &mut layers, &views, view)?,
            groups: groups::keep(&file, &mut layers, group)?,
            layers,
            views,
            ..Self::new(OpenedKind::Exr(file), holding)
        }))
    }

    fn new(kind: OpenedKind, holding: Holding) -> Self {
        Self {
            kind,
            layers: Vec::new(),
            groups: Groups::default(),
            views: Vec::new(),
            view: None,
            by_numbers: OnceCell::new(),
            judged: Judged::default(),
            companions: RefCell::default(),
            holding,
        }
    }

    /// The EXR it is, if it is one.
    pub(crate) fn exr(&self) -> Option<&ExrFile> {
        match &self.kind {
            OpenedKind::Exr(file) => Some(file),
            OpenedKind::Photo(_) => None,
        }
    }

    /// The photo it is, if it is one.
    pub(in crate::io) fn photo(&self) -> Option<&StoredPhoto> {
        match &self.kind {
            OpenedKind::Exr(_) => None,
            OpenedKind::Photo(photo) => Some(photo),
        }
    }

    /// The pixels meant to be shown.
    pub(crate) fn display(&self) -> Window {
        match &self.kind {
            OpenedKind::Exr(file) => file.display_window,
            OpenedKind::Photo(photo) => photo.header.window(),
        }
    }

    /// A companion file: of the same view and group, if it has several. It is opened once.
    pub(crate) fn open_companion(&self, path: &Path) -> Result<Rc<Self>> {
        if let Some(file) = self.companions.borrow().get(path) {
            return Ok(file.clone());
        }
        let open = |wanted| Self::open_held(path, wanted, self.holding.clone());
        let mut file = open([None; 2])?;
        let wanted = self.selection_in(&file);
        if wanted != [None; 2] {
            file = open(wanted)?;
        }
        let mut companions = self.companions.borrow_mut();
        Ok(companions.entry(path.into()).or_insert(file).clone())
    }

    /// Its own view and group, as far as `other` has several.
    fn selection_in(&self, other: &Self) -> Selection<'_> {
        let names = &other.groups.names;
        let is_there = |own: &&str| names.iter().any(|name| name.eq_ignore_ascii_case(own));
        [
            self.view.as_deref().filter(|_| !other.views.is_empty()),
            self.groups.taken.as_deref().filter(is_there),
        ]
    }

    /// The channels of the layer called `name`, for `role`; those of the group in use come first.
    pub(crate) fn named(&self, name: &str, role: Role) -> Option<Match> {
        let mut sets = [&self.layers, &self.groups.apart].into_iter();
        sets.find_map(|layers| roles::named(layers, name, role))
    }

    /// Whether a channel belongs to another group than the one in use.
    pub(crate) fn is_apart(&self, ChannelId { part, channel }: ChannelId) -> bool {
        let mut apart = self.groups.apart.iter().filter(|layer| layer.part == part);
        apart.any(|layer| layer.components.iter().any(|(_, own)| *own == channel))
    }

    /// All layers that flags can name.
    pub(crate) fn all_layers(&self) -> impl Iterator<Item = &Layer> {
        self.layers.iter().chain(&self.groups.apart)
    }

    /// The layer that plays `role` by its numbers, where none does by its name.
    pub(crate) fn role_by_numbers(&self, role: Role) -> Option<&RoleByNumbers> {
        let file = self.exr().filter(|_| NUMBERED.contains(&role))?;
        let find = || roles_by_numbers(file, &self.layers);
        let mut found = self.by_numbers.get_or_init(find).iter();
        found.find(|found| found.role == role)
    }

    /// Whether it is a photo whose pixels are normals.
    pub(crate) fn is_normal_map(&self) -> bool {
        let judge = |photo| {
            let pair = || self.map_codes()?.pair;
            holds_normals(photo) || pair().is_some_and(|pair| pair.is_sure)
        };
        let is_map = &self.judged.is_normal_map;
        self.photo()
            .is_some_and(|photo| *is_map.get_or_init(|| judge(photo)))
    }

    /// What the codes of a photo hold, as a normal map.
    pub(crate) fn map_codes(&self) -> Option<&MapCodes> {
        let photo = self.photo()?;
        Some(self.judged.codes.get_or_init(|| MapCodes::of(photo)))
    }

    /// The bits of the codes that the floats of a photo of light are, if they are whole numbers.
    pub(crate) fn bits_of_floats(&self) -> Option<u8> {
        let bits = &self.judged.bits_of_floats;
        *bits.get_or_init(|| self.photo()?.bits_of_floats())
    }

    /// The layer whose name is most like `name`, for messages.
    pub(crate) fn alike(&self, name: &str) -> Option<&str> {
        nearest::alike(self.all_layers(), name)
    }

    pub(crate) fn path(&self) -> &Path {
        match &self.kind {
            OpenedKind::Exr(file) => &file.path,
            OpenedKind::Photo(photo) => &photo.header.path,
        }
    }

    /// Its photo and its companions, decoded, with what has been judged of them.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for an EXR.
    #[cfg(feature = "cli")]
    pub(crate) fn photos(&self) -> Result<Vec<WholePhoto>> {
        let Some(photo) = self.photo() else {
            return Err(Error::Unsupported {
                path: self.path().to_path_buf(),
                found: "is an EXR, and the cells of --grid are cut from pictures".into(),
                remedy: "save it as a PNG or TIFF of 16 bits".into(),
            });
        };
        // Cells that are cut from it are read alike.
        self.bits_of_floats();
        let mut all = vec![WholePhoto {
            header: photo.header.clone(),
            samples: photo.take_samples()?,
            judged: self.judged.clone(),
        }];
        for file in self.companions.borrow().values() {
            all.extend(file.photos()?);
        }
        Ok(all)
    }

    /// Releases the samples of photos, its own and those of companion files.
    #[cfg(feature = "cli")]
    pub(crate) fn release(&self) {
        let companions = self.companions.borrow();
        companions.values().for_each(|file| file.release());
        if let Some(photo) = self.photo() {
            photo.release();
        }
    }

    /// The pixels meant to be shown, and a pixel's width over its height. A photo shows the `window` of all that it holds.
    pub(crate) fn shown(&self, window: Window) -> (Window, f32) {
        let of_file = |file: &ExrFile| (file.display_window, file.pixel_aspect);
        self.exr().map_or((window, 1.0), of_file)
    }

    /// The layers to list in messages, or `otherwise` without any.
    pub(crate) fn found(&self, otherwise: &str) -> String {
        match self.layer_names() {
            names if names.is_empty() => otherwise.into(),
            names => listed(&names),
        }
    }

    /// Names of the layers, for messages: a photo has none.
    pub(crate) fn layer_names(&self) -> Vec<String> {
        self.all_layers().map(layer_label).collect()
    }
}

/// The layers of all parts and views of a file.
pub(crate) fn layers_of(file: &ExrFile) -> Vec<Layer> {
    roles::layers(file.parts.iter().map(|part| {
        let names = part.channels.iter().map(|c| c.name.as_str());
        (part.name.as_deref(), names.collect())
    }))
}

/// A layer's name, or its bare channels where it has none.
fn layer_label(layer: &Layer) -> String {
    if !layer.name.is_empty() {
        return layer.name.clone();
    }
    let components = layer.components.iter();
    components.map(|(c, _)| c.to_ascii_uppercase()).collect()
}

fn has_exr_magic(path: &Path) -> Result<bool> {
    let mut file = open_buffered(path)?;
    let start = file.fill_buf().map_err(Error::io(path, "read"))?;
    Ok(start.starts_with(&exr::MAGIC))
}
