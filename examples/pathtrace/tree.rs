//! The bounding-volume tree: built by the `bvh` crate, traversed here.
//!
//! The crate's own traversals return every shape whose box the ray's line hits. A path tracer needs the nearest hit,
//! and can skip all boxes behind the current one.

use super::geometry::{Hit, Ray, Shape};
use bvh::bounding_hierarchy::BoundingHierarchy;
use bvh::bvh::{Bvh, BvhNode};
use glam::Vec3;

/// Both boxes below a node, and their content.
#[derive(Debug, Clone, Copy)]
struct Node {
    boxes: [[Vec3; 2]; 2],
    children: [Child; 2],
}

#[derive(Debug, Clone, Copy)]
enum Child {
    Node(u32),
    Shape(u32),
}

/// Shapes in a tree.
pub(crate) struct Tree {
    nodes: Vec<Node>,
    root: Option<Child>,
    /// In the order of traversal.
    shapes: Vec<Shape>,
}

/// Least component of a direction: its reciprocal times no distance at all is 0 and no NaN.
const LEAST_COMPONENT: f32 = 1e-20;

impl Tree {
    pub(crate) fn new(mut shapes: Vec<Shape>) -> Self {
        let built = Bvh::build_par(&mut shapes);
        let mut tree = Self {
            nodes: Vec::with_capacity(shapes.len()),
            root: None,
            shapes: Vec::with_capacity(shapes.len()),
        };
        if !built.nodes.is_empty() {
            tree.root = Some(tree.copied(&built.nodes, 0, &shapes));
        }
        tree
    }

    /// Copies the subtree of the builder's node `index`.
    fn copied(&mut self, from: &[BvhNode<f32, 3>], index: usize, shapes: &[Shape]) -> Child {
        match &from[index] {
            BvhNode::Leaf { shape_index, .. } => {
                self.shapes.push(shapes[*shape_index]);
                Child::Shape(self.shapes.len() as u32 - 1)
            }
            BvhNode::Node {
                child_l_index,
                child_l_aabb,
                child_r_index,
                child_r_aabb,
                ..
            } => {
                let place = self.nodes.len();
                let boxes = [child_l_aabb, child_r_aabb]
                    .map(|b| [b.min, b.max].map(|corner| Vec3::new(corner.x, corner.y, corner.z)));
                // The children's places are known once they are there.
                self.nodes.push(Node {
                    boxes,
                    children: [Child::Node(0); 2],
                });
                let children =
                    [*child_l_index, *child_r_index].map(|child| self.copied(from, child, shapes));
                self.nodes[place].children = children;
                Child::Node(place as u32)
            }
        }
    }

    /// The shape of a hit.
    pub(crate) fn shape(&self, hit: &Hit) -> &Shape {
        &self.shapes[hit.shape as usize]
    }

    /// The first thing that the ray meets.
    #[inline]
    pub(crate) fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let mut found: Option<Hit> = None;
        self.walk(ray, f32::INFINITY, |hit| {
            found = Some(hit);
            Some(hit.distance)
        });
        found
    }

    /// Whether the ray is obstructed before `distance`.
    #[inline]
    pub(crate) fn is_blocked(&self, ray: &Ray, distance: f32) -> bool {
        let mut blocked = false;
        self.walk(ray, distance, |_| {
            blocked = true;
            None
        });
        blocked
    }

    /// Calls `each` for hits nearer than `farthest`; it returns the new limit, or that it needs no more hits.
    #[inline(always)]
    fn walk(&self, ray: &Ray, mut farthest: f32, mut each: impl FnMut(Hit) -> Option<f32>) {
        let steep = ray.direction.abs().max(Vec3::splat(LEAST_COMPONENT));
        let inverse = steep.copysign(ray.direction).recip();
        let mut pending: Vec<(Child, f32)> = Vec::with_capacity(64);
        let Some(mut child) = self.root else { return };
        loop {
            match child {
                Child::Shape(index) => {
                    let shape = &self.shapes[index as usize];
                    if let Some((distance, uv)) = shape.form.met(ray, 0.0, farthest) {
                        let hit = Hit {
                            distance,
                            uv,
                            shape: index,
                        };
                        match each(hit) {
                            Some(nearer) => farthest = nearer,
                            None => return,
                        }
                    }
                }
                Child::Node(index) => {
                    let node = &self.nodes[index as usize];
                    let entries = node.boxes.map(|b| entry(&b, ray, inverse, farthest));
                    // The nearer box first, the other one later.
                    match entries {
                        [Some(a), Some(b)] => {
                            let near = usize::from(b < a);
                            pending.push((node.children[1 - near], a.max(b)));
                            child = node.children[near];
                            continue;
                        }
                        [Some(_), None] => {
                            child = node.children[0];
                            continue;
                        }
                        [None, Some(_)] => {
                            child = node.children[1];
                            continue;
                        }
                        [None, None] => {}
                    }
                }
            }
            // Back to the last box put off, unless a hit before it has been found since.
            loop {
                let Some((next, entry)) = pending.pop() else {
                    return;
                };
                if entry < farthest {
                    child = next;
                    break;
                }
            }
        }
    }
}

/// Distance along the ray at which it enters the box, if before `farthest`.
#[inline(always)]
fn entry([low, high]: &[Vec3; 2], ray: &Ray, inverse: Vec3, farthest: f32) -> Option<f32> {
    let (a, b) = (
        (*low - ray.origin) * inverse,
        (*high - ray.origin) * inverse,
    );
    let (first, last) = (a.min(b), a.max(b));
    let start = first.x.max(first.y).max(first.z).max(0.0);
    // A rounding wide, so that flat boxes are not missed.
    let end = last.x.min(last.y).min(last.z) * (1.0 + 4.0 * f32::EPSILON);
    (start <= end && start < farthest).then_some(start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Form;
    use crate::sampler::Sampler;

    /// Triangles, spheres and rectangles all over a cube.
    fn clutter() -> Vec<Shape> {
        let vector = |s: &mut Sampler| Vec3::new(s.one(), s.one(), s.one()) - 0.5;
        let shape = |i: u32| {
            let mut s = Sampler::new(3, i, 0);
            let corner = 4.0 * vector(&mut s);
            let sides = [vector(&mut s), vector(&mut s)];
            let form = match i % 3 {
                0 => Form::Sphere {
                    center: corner,
                    radius: 0.3 * s.one(),
                },
                1 => Form::Rectangle { corner, sides },
                _ => Form::Triangle {
                    corner,
                    sides,
                    face: i,
                },
            };
            Shape::new(form, i as usize)
        };
        (0..500).map(shape).collect()
    }

    #[test]
    fn a_walk_finds_what_trying_every_shape_finds() {
        let shapes = clutter();
        let tree = Tree::new(shapes.clone());
        let mut hits = 0;
        for i in 0..5000 {
            let mut s = Sampler::new(4, i, 0);
            let origin = 6.0 * (Vec3::new(s.one(), s.one(), s.one()) - 0.5);
            let direction = Vec3::new(s.one(), s.one(), s.one()) - 0.5;
            let ray = Ray {
                origin,
                direction: direction.normalize(),
            };
            let all = shapes.iter().filter_map(|shape| {
                let (distance, _) = shape.form.met(&ray, 0.0, f32::INFINITY)?;
                Some((distance, shape.object))
            });
            let expected = all.min_by(|a, b| a.0.total_cmp(&b.0));
            let found = tree.nearest(&ray);
            let object = found.map(|hit| (hit.distance, tree.shape(&hit).object));
            assert_eq!(object, expected);
            if let Some((distance, _)) = expected {
                hits += 1;
                assert!(tree.is_blocked(&ray, 1.01 * distance));
                assert!(!tree.is_blocked(&ray, 0.99 * distance));
            }
        }
        assert!(hits > 1000, "only {hits} rays meet anything");
    }

    #[test]
    fn nothing_is_met_in_an_empty_tree() {
        let ray = Ray {
            origin: Vec3::ZERO,
            direction: Vec3::X,
        };
        assert!(Tree::new(Vec::new()).nearest(&ray).is_none());
    }
}
