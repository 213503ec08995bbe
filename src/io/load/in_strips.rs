//! Reading a frame some rows at a time.

use super::bundle::gathered;
use super::frame_sources::FrameSources;
use super::light_layers::LightSources;
use super::opened::{Holding, Opened, WholePhoto};
use super::sources::RoleSource;
use crate::error::{Error, Result};
use crate::frame::{UNROUNDING_PHASE, UNROUNDING_REACH, Window};
use crate::io::inputs::{Inputs, LobeChoice, Needs};
use crate::io::load::{Loaded, load_from};
use crate::io::photo::StoredPhoto;
use crate::io::roles::Role;
use std::rc::Rc;
use std::sync::Arc;

/// Memory per pixel, in bytes, for mending vectors. Undoing their rounding takes most: three components, and for one of
/// them the codes, the steps and the wide neighbourhoods. Noisy ones read a few rows more, which is not known here.
const MENDING_BYTES: usize = 7 * size_of::<f32>();

/// The files of a frame, opened once for any number of loads of its rows.
pub(crate) struct InputFiles {
    main: Rc<Opened>,
}

/// Size of a frame, by its headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FrameExtent {
    /// The pixels that it has.
    pub window: Window,
    /// Bytes for its decoded photos, including those for mending normals.
    pub photo_bytes: u64,
}

impl InputFiles {
    /// Opens the picture of `inputs`, with this policy for samples of photos.
    ///
    /// # Errors
    /// Any [`crate::Error`] of reading a header.
    pub(crate) fn open(inputs: &Inputs, holding: Holding) -> Result<Self> {
        let (inputs, _) = gathered(inputs)?;
        let main = Opened::open_picture(&inputs, holding)?;
        Ok(Self { main })
    }

    /// The photos, decoded, of which parts are to be read.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if one is an EXR.
    pub(crate) fn photos(&self) -> Result<Arc<Vec<WholePhoto>>> {
        self.main.photos().map(Arc::new)
    }

    /// Size of the frame of `inputs`.
    ///
    /// # Errors
    /// As [`load`], except errors that only pixels reveal; [`Error::Unsupported`] where normals are made from depth.
    pub(crate) fn extent(&self, inputs: &Inputs, needs: Needs) -> Result<FrameExtent> {
        let (inputs, _) = gathered(inputs)?;
        let light = LightSources::resolve(&inputs, &self.main)?;
        let sources = FrameSources::resolve(&inputs, &self.main, needs, !light.is_empty())?;
        if sources.get(Role::Normal).is_none() {
            return Err(Error::Unsupported {
                path: inputs.picture.clone(),
                found: "has no normals, and those of its depth take it whole".into(),
                remedy: "allow more with --max-memory".into(),
            });
        }
        let all = sources.roles.iter().chain(&light.sources);
        let mut photos: Vec<_> = all.filter_map(|source| source.file.photo()).collect();
        photos.sort_by_key(|photo| std::ptr::from_ref(*photo));
        photos.dedup_by_key(|photo| std::ptr::from_ref(*photo));
        Ok(FrameExtent {
            window: sources.common_window(&light)?,
            photo_bytes: photos
                .into_iter()
                .map(|photo| photo.header.bytes())
                .sum::<u64>()
                + sources.get(Role::Normal).map_or(0, mending_bytes),
        })
    }

    /// Reads the frame, or the rows of it named by `inputs`.
    ///
    /// # Errors
    /// As [`load`].
    pub(crate) fn load(&self, inputs: &Inputs, needs: Needs) -> Result<Loaded> {
        let (inputs, note) = gathered(inputs)?;
        let mut loaded = load_from(self.main.clone(), &inputs, needs)?;
        loaded.warnings.splice(..0, note);
        Ok(loaded)
    }

    /// Releases decoded photos.
    pub(crate) fn release(&self) {
        self.main.release();
    }
}

impl Loaded {
    /// Lets parts of the picture that this was read of be read as it was.
    pub(crate) fn settle(&self, inputs: &mut Inputs) {
        self.conventions.force(inputs);
        // Whether light passes are those of the picture is not judged again either.
        let light = &self.frame.light;
        if let Some(wanted) = &mut inputs.light
            && wanted.lobes == LobeChoice::Auto
        {
            wanted.lobes = match light.lobes.is_empty() {
                true => LobeChoice::Off,
                false => LobeChoice::On,
            };
        }
        if let Some(wanted) = &mut inputs.light {
            wanted.gloss_is_tint = light.gloss.as_ref().map(|gloss| gloss.is_tint);
            wanted.gloss &= wanted.gloss_is_tint.is_some();
        }
    }
}

/// Bytes for mending the vectors of `source` while rows of them are read.
fn mending_bytes(source: &RoleSource) -> u64 {
    let bytes = |photo: &StoredPhoto| {
        let rows = (2 * UNROUNDING_REACH + UNROUNDING_PHASE).min(photo.header.height);
        (rows * photo.header.width * MENDING_BYTES) as u64
    };
    let photo = source.file.photo();
    let coded = photo.filter(|photo| photo.header.may_hold_coded_vectors());
    coded.map_or(0, bytes)
}
