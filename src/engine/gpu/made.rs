//! Results of stages on the device, for later stages and for read-back.

use crate::engine::gpu::surface::Picture;
use crate::product::Product;

/// The descriptor on the device, as far as the plan needs it.
pub(crate) struct Shape {
    pub(crate) conductance: wgpu::Buffer,
    /// Silhouette and crease weight of each pixel.
    pub(crate) weights: Option<wgpu::Buffer>,
    pub(crate) gradient: wgpu::Buffer,
    /// The gradient at further scales.
    pub(crate) more_gradients: Vec<wgpu::Buffer>,
    /// The Hessian at the first scale, if curvature is wanted.
    pub(crate) hessian: Option<Hessian>,
}

impl Shape {
    /// The trace of the Hessian.
    pub(crate) fn trace(&self) -> &wgpu::Buffer {
        let hessian = self.hessian.as_ref();
        &hessian
            .expect("curvature is planned with its Hessian")
            .trace
    }

    /// All of its buffers.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let hessian = self.hessian.into_iter();
        let hessian = hessian.flat_map(|Hessian { trace, entries }| {
            std::iter::once(trace).chain(entries.into_iter().flatten())
        });
        [self.conductance, self.gradient]
            .into_iter()
            .chain(self.weights)
            .chain(self.more_gradients)
            .chain(hessian)
    }
}

/// The Hessian on the device.
pub(crate) struct Hessian {
    pub(crate) trace: wgpu::Buffer,
    /// Its entries xx, xy and yy, if needed.
    pub(crate) entries: Option<[wgpu::Buffer; 3]>,
}

/// Curvatures derived from the Hessian for the layers of the descriptor.
pub(crate) struct Curvatures {
    /// u, v, mean and kappa of each pixel.
    pub(crate) curvature: wgpu::Buffer,
    /// The direction of the larger view-centred curvature by magnitude.
    pub(crate) direction: wgpu::Buffer,
}

/// All results of a run so far.
#[derive(Default)]
pub(crate) struct Made {
    pub(crate) shape: Option<Shape>,
    /// By scale, the first scale first.
    pub(crate) curvatures: Vec<Curvatures>,
    /// Directions of the surface's own curvature, x and y, and whether it is a plane.
    pub(crate) directions: Option<[wgpu::Buffer; 3]>,
    /// The picture, or the input of the stages that make it.
    pub(crate) picture: Option<Picture>,
}

/// Buffers that hold products, in order. With fewer buffers than planes, each pixel has several samples.
pub(crate) struct Layer {
    pub(crate) products: &'static [Product],
    pub(crate) buffers: Vec<wgpu::Buffer>,
}

impl Made {
    /// All layers of the descriptor, further scales last.
    pub(crate) fn layers(&self) -> Vec<Layer> {
        let Some(shape) = &self.shape else {
            return Vec::new();
        };
        let hessian = shape.hessian.as_ref();
        let entries = hessian.and_then(|hessian| hessian.entries.clone());
        let first = self.curvatures.first();
        let of_first = first.map(|first| &first.curvature);
        let layer = |products, buffers| Layer { products, buffers };
        let one = |buffer: Option<&wgpu::Buffer>| buffer.into_iter().cloned().collect();
        let mut layers = vec![
            layer(&[Product::Conductance], one(Some(&shape.conductance))),
            layer(
                &[Product::Silhouette, Product::Crease],
                one(shape.weights.as_ref()),
            ),
            layer(&[Product::Gradient], one(Some(&shape.gradient))),
            layer(&[Product::Hessian], entries.into_iter().flatten().collect()),
            layer(&CURVATURES, one(of_first)),
            layer(
                &[Product::ViewDirection],
                one(first.map(|first| &first.direction)),
            ),
        ];
        let further = self.curvatures.iter().skip(1);
        layers.extend(further.map(|scale| layer(&CURVATURES, one(Some(&scale.curvature)))));
        layers.retain(|layer| !layer.buffers.is_empty());
        layers
    }

    /// All buffers except those of the picture.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let curvatures = self.curvatures.into_iter();
        let curvatures = curvatures.flat_map(|scale| [scale.curvature, scale.direction]);
        let shape = self.shape.into_iter().flat_map(Shape::into_buffers);
        shape.chain(curvatures)
    }
}

/// The products in a buffer of [`Curvatures::curvature`], in order.
const CURVATURES: [Product; 2] = [Product::Curvature, Product::MappedCurvature];
