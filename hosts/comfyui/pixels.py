"""Tensors of ComfyUI as arrays, and pictures as tensors."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch


def arrays(tensor: Any, channels: int) -> np.ndarray:
    """A batch as float32 of images x rows x columns x channels; with 0 channels, as for masks, no last axis."""
    batch = tensor.detach().to("cpu", torch.float32).numpy()
    if channels == 0:
        # A mask; of an image that is grey, one channel.
        return batch[None] if batch.ndim == 2 else batch if batch.ndim == 3 else batch[..., 0]
    # Alpha is left out, grey repeated.
    return np.repeat(batch, channels, axis=-1) if batch.shape[-1] == 1 else batch[..., :channels]


def tensor_of(batch: list[np.ndarray]) -> torch.Tensor:
    """Images of one size as a batch."""
    return torch.from_numpy(np.ascontiguousarray(np.stack(batch), dtype=np.float32))


def codes(batch: np.ndarray) -> np.ndarray:
    """A batch of 8 bits as such, as images of files are: then its steps are known to be rounding, not relief."""
    nearest = np.round(np.clip(batch, 0, 1) * 255)
    return nearest.astype(np.uint8) if np.abs(batch * 255 - nearest).max(initial=0) < 1e-3 else batch


def linear(shown: np.ndarray) -> np.ndarray:
    """sRGB as linear light (IEC 61966-2-1)."""
    shown = np.maximum(shown, 0)
    curve = ((shown + 0.055) / 1.055) ** 2.4
    return np.where(shown <= 0.04045, shown / 12.92, curve).astype(np.float32)


def encoded(light: np.ndarray) -> np.ndarray:
    """Linear light as sRGB."""
    light = np.maximum(light, 0)
    curve = 1.055 * light ** (1 / 2.4) - 0.055
    return np.where(light <= 0.0031308, light * 12.92, curve).astype(np.float32)


def displayed(picture: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """A picture as it is to be shown, 0..1.

    ``shown`` is what a PNG of 8 bits holds, after exposure and the compression of highlights. Where these leave the
    linear ``picture`` as it is, its value rounds to that byte: then it is taken, so that nodes in a row lose nothing.
    """
    fine = encoded(picture)
    coarse = shown[..., :3].astype(np.float32) / 255
    return np.where(np.abs(fine - coarse) <= 0.5001 / 255, np.clip(fine, 0, 1), coarse)
