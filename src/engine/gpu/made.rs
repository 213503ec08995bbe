//! What stages have made on the device, for those after them and to be read.

use crate::engine::gpu::surface::Picture;
use crate::product::Product;

/// The descriptor on the device, as far as a plan asks for it.
pub(crate) struct Shape {
    pub(crate) conductance: wgpu::Buffer,
    /// Silhouette and crease weight of each pixel.
    pub(crate) weights: Option<wgpu::Buffer>,
    pub(crate) gradient: wgpu::Buffer,
    /// The gradient at further scales.
    pub(crate) more_gradients: Vec<wgpu::Buffer>,
    /// The Hessian at the first scale, unless it is used only once, where it is made.
    pub(crate) hessian: Option<Hessian>,
}

impl Shape {
    /// The plane that the gain is chosen from.
    pub(crate) fn of_gain(&self) -> [&wgpu::Buffer; 3] {
        let hessian = self.hessian.as_ref();
        let trace = &hessian.expect("the gain takes the trace").trace;
        [trace, &self.conductance, trace]
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
    /// Its entries xx, xy and yy, where they are wanted.
    pub(crate) entries: Option<[wgpu::Buffer; 3]>,
}

/// Curvatures derived from the Hessian for the layers of the descriptor.
pub(crate) struct Curvatures {
    /// u, v, mean and kappa of each pixel.
    pub(crate) curvature: wgpu::Buffer,
    /// The direction of the view-centred curvature larger in size.
    pub(crate) direction: wgpu::Buffer,
}

/// The white level of each term, in a buffer like that of what is chosen.
pub(crate) type TermWhites = Vec<(&'static str, wgpu::Buffer)>;

/// All that a run has made so far.
#[derive(Default)]
pub(crate) struct Made {
    pub(crate) shape: Option<Shape>,
    /// Of the first scale, and of those after it.
    pub(crate) curvatures: Vec<Curvatures>,
    /// Directions of the surface's own curvature, x and y.
    pub(crate) directions: Option<[wgpu::Buffer; 2]>,
    /// The picture, or what it is made of.
    pub(crate) picture: Option<Picture>,
    /// White levels of the terms of light.
    pub(crate) term_whites: TermWhites,
}

/// Buffers that hold products, one after the other. Where there are fewer than planes each pixel has several samples.
pub(crate) struct Layer {
    pub(crate) products: &'static [Product],
    pub(crate) buffers: Vec<wgpu::Buffer>,
}

impl Made {
    /// All layers of the descriptor, those of further scales last.
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
            layer(
                &[Product::Direction],
                self.directions.iter().flatten().cloned().collect(),
            ),
        ];
        let further = self.curvatures.iter().skip(1);
        layers.extend(further.map(|scale| layer(&CURVATURES, one(Some(&scale.curvature)))));
        layers.retain(|layer| !layer.buffers.is_empty());
        layers
    }

    /// All buffers but those of the picture.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let curvatures = self.curvatures.into_iter();
        let curvatures = curvatures.flat_map(|scale| [scale.curvature, scale.direction]);
        let shape = self.shape.into_iter().flat_map(Shape::into_buffers);
        shape
            .chain(curvatures)
            .chain(self.directions.into_iter().flatten())
    }
}

/// The products in a buffer of [`Curvatures::curvature`], in order.
const CURVATURES: [Product; 2] = [Product::Curvature, Product::MappedCurvature];
