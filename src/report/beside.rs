//! Results of a device compared with the CPU.

use super::asked::Asked;
use super::gpu::{Device, ProductRow};
use super::pictures::{self, PictureRow};
use super::scenes::Scene;
use crate::Result;
use serde::Serialize;

/// Results of a device.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum GpuReport {
    /// Why there are no measurements.
    NotMeasured(String),
    /// The measurements.
    Measured {
        device: String,
        is_software: bool,
        /// Differences of its products from the CPU's.
        products: Vec<ProductRow>,
        /// Relit pictures and drawings.
        pictures: Vec<PictureRow>,
    },
}

/// The device at the end of the report, and its differences from the CPU.
pub(super) fn measured(
    device: &Device,
    asked: &Asked,
    scenes: &[Scene],
) -> Result<Option<GpuReport>> {
    let gpu = match device {
        Device::Unknown => return Ok(None),
        Device::NotMeasured(why) => return Ok(Some(GpuReport::NotMeasured(why.clone()))),
        Device::Measured(gpu) => gpu,
    };
    (asked.progress)("the device's products and pictures beside the CPU's");
    let scenes = scenes.iter().map(|scene| {
        let shape = scene.shape(asked.shape.tolerance);
        (scene.name, &scene.frame, shape)
    });
    let own = (asked.name, asked.frame, asked.shape);
    let frames: Vec<_> = std::iter::once(own).chain(scenes).collect();
    let products = gpu.products(&frames)?;
    let pictures = pictures::rows(gpu, asked.frame, asked.shape, asked.effort())?;
    Ok(Some(match gpu.failure()? {
        Some(why) => GpuReport::NotMeasured(why),
        None => GpuReport::Measured {
            device: gpu.name.clone(),
            is_software: gpu.is_software,
            products,
            pictures,
        },
    }))
}
