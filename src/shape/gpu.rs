//! The shape of a surface on the device: weights, gradient, diffusion, Hessian, curvature.

use crate::engine::gpu::run::Run;
use crate::frame::Frame;
use crate::light::enhancement::Subject;
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::auto_levels::gpu::{Search, Searching};
use crate::shape::curvature::gpu::Hessian;
use crate::shape::edges::gpu::Edges;

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
    /// What the gain is chosen from.
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

impl Run<'_> {
    /// Finds the shape that `plan` asks for.
    pub(crate) fn find_shape(&mut self, plan: &Plan, frame: &Frame) -> Shape {
        let edges = self.edges(plan, frame);
        self.shape_along(plan, edges)
    }

    /// The shape between edges.
    pub(crate) fn shape_along(&mut self, plan: &Plan, edges: Edges) -> Shape {
        let Edges {
            conductance,
            weights,
            gradient,
        } = edges;
        let mut gradients = match plan.sweeps.count() > 0 && plan.wants(Product::Gradient) {
            true => self.diffused(plan, gradient, &conductance),
            false => {
                let copies = plan.more_px.len();
                let more = (0..copies)
                    .map(|_| self.copy_of(&gradient))
                    .collect::<Vec<_>>();
                std::iter::once(gradient).chain(more).collect()
            }
        };
        let more_gradients = gradients.split_off(1);
        let gradient = gradients.remove(0);
        let wants = (plan.wants_curvature()) && !scales_by_gradient(plan);
        let hessian = wants.then(|| {
            let entries = plan.wants(Product::Hessian);
            self.hessian(plan, &gradient, &conductance, entries)
        });
        Shape {
            conductance,
            weights,
            gradient,
            more_gradients,
            hessian,
        }
    }

    /// Chooses the gain of curvature, where it is left open.
    pub(crate) fn choose_gain(&mut self, plan: &Plan, shape: &Shape) {
        if plan.chooses_gain() {
            let size = self.surface.size.map(|side| side as usize);
            let factor = plan.resolution_factor as f32;
            let search = Searching::new(self, Search::Gain { size, factor });
            let chosen = self.chosen.clone();
            search.choose(self, shape.of_gain(), &chosen);
        }
    }
}

/// Whether the trace of the Hessian is used once, and where it is made.
fn scales_by_gradient(plan: &Plan) -> bool {
    let is_used_again = plan.runs("auto-gain")
        || plan
            .enhancement
            .is_some_and(|enhancement| enhancement.occlusion > 0.0);
    plan.enhancement.is_some() && plan.scaled() == Some(Subject::Picture) && !is_used_again
}
