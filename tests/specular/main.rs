//! Mirrors and lenses: what bent sight lines meet, and how strokes of it are seen.

mod exact;
mod propagation;
