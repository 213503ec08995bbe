"""The nodes: sockets, widgets and results."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
import pyrelievo
from pyrelievo._commands import default_engine
from pyrelievo._settings import rows, typed

from .pixels import arrays, codes, displayed, linear, tensor_of
from .widgets import given, settings, widgets

#: Layers by the names of their sockets: the layer of a frame, its type and how many channels it has.
SOCKETS = {
    "image": ("color", "IMAGE", 3),
    "normal": ("normal", "IMAGE", 3),
    "depth": ("depth", "IMAGE", 0),
    "albedo": ("albedo", "IMAGE", 3),
    "mask": ("mask", "MASK", 0),
}

TOOLTIPS = {
    "image": "The picture, in sRGB.",
    "normal": (
        "Normal map: red right, green up, blue toward the viewer, each from 0 to 1 (OpenGL). Black is no surface. "
        "normal_flip takes maps with other directions. Without one normals are those of the depth map."
    ),
    "depth": "Depth map: for silhouettes, and in the place of a normal map. depth_kind says what it holds.",
    "albedo": "The surface's own colour, in sRGB. Estimated from the image if not given.",
    "normal_flip": "Axes of the normal map that point the wrong way: y if green is down (DirectX), x if red is left.",
}

#: Axes of a normal map that may point the wrong way: those of DirectX have y downward.
FLIPS = ["none", "y", "x", "xy"]

#: Images that automatic settings are chosen from, as of a sequence of files.
SAMPLES = 5


def choices_for_all(each: list[list[tuple[str, str]]]) -> list[tuple[str, str]]:
    """Choices that suit all images: of each number the median."""
    found: dict[str, list[list[float]]] = {}
    for name, value in (pair for choices in each for pair in choices):
        found.setdefault(name, []).append([float(number) for number in value.split(",")])
    medians = {name: np.sort(numbers, axis=0)[len(numbers) // 2] for name, numbers in found.items()}
    return [(name, ",".join(repr(float(number)) for number in median)) for name, median in medians.items()]


def progress_of(total: int) -> Any:
    """A function that shows how far a batch is, and ends it where the user asks for that."""
    try:
        from comfy.model_management import throw_exception_if_processing_interrupted
        from comfy.utils import ProgressBar
    except ImportError:  # outside of the server
        return lambda done: None
    bar = ProgressBar(1000)

    def show(done: float) -> None:
        throw_exception_if_processing_interrupted()
        bar.update_absolute(round(1000 * done / total))

    return show


class Node:
    """What the nodes have in common: a command that is run over a batch."""

    COMMAND: str
    REQUIRED: tuple[str, ...]
    OPTIONAL: tuple[str, ...]

    CATEGORY = "image/relievo"
    FUNCTION = "run"

    @classmethod
    def INPUT_TYPES(cls) -> dict[str, dict[str, tuple[Any, ...]]]:
        roles = rows(cls.COMMAND)

        def socket(name: str) -> tuple[str, dict[str, Any]]:
            tooltip = TOOLTIPS.get(name) or roles[name].help.replace(": a layer of IN or a file", "") + "."
            return SOCKETS[name][1], {"tooltip": tooltip}

        flip = FLIPS, {"default": FLIPS[0], "tooltip": TOOLTIPS["normal_flip"]}
        kinds = [word for word in roles["depth_kind"].words if word != "auto"]
        kind = kinds, {"default": "white-near", "tooltip": roles["depth_kind"].help + ".", "advanced": True}
        own = widgets(cls.COMMAND)
        known = settings(cls.COMMAND)
        first = {name: own.pop(name) for name in list(own) if known[name].common}
        rest = {name: (kind, options | {"advanced": True}) for name, (kind, options) in own.items()}
        return {
            "required": {**{name: socket(name) for name in cls.REQUIRED}, "normal_flip": flip, **first},
            "optional": {**{name: socket(name) for name in cls.OPTIONAL}, "depth_kind": kind, **rest},
        }

    def run(self, **values: Any) -> tuple[Any, ...]:
        """What the command makes of each image of the batch."""
        batches = {}
        for name in (*self.REQUIRED, *self.OPTIONAL):
            layer, _, channels = SOCKETS[name]
            if values.get(name) is not None:
                batches[layer] = arrays(values[name], channels)
                if name in ("image", "albedo"):
                    batches[layer] = linear(batches[layer])
        count = max((len(batch) for batch in batches.values()), default=1)
        for layer, batch in batches.items():
            if len(batch) not in (1, count):
                raise ValueError(f"{layer} has {len(batch)} images, others have {count}; give as many, or one for all")
        roles = {"normal_encoding": "unsigned", "normal_flip": values.get("normal_flip", FLIPS[0])}
        if "depth" in batches:
            batches["depth"] = codes(batches["depth"])
            roles["depth_kind"] = values.get("depth_kind", "white-near")
        texts = typed(self.COMMAND, given(self.COMMAND, values))

        def make(at: int, more: list[tuple[str, str]], progress: Any) -> Any:
            layers = {layer: batch[at % len(batch)] for layer, batch in batches.items()}
            frame = pyrelievo.Frame(**layers, **roles)
            return default_engine().run(self.COMMAND, [*texts, *more], frame._frame, "shown", progress)

        samples = sample(count) if count > 1 else []
        show = progress_of(count + len(samples))
        warnings: dict[str, None] = {}
        each = []
        for done, at in enumerate(samples):
            made = make(at, [], lambda _, share, done=done: show(done + share))
            each.append(made.choices)
        chosen = choices_for_all(each)
        results = []
        for at in range(count):
            made = make(at, chosen, lambda _, share, at=at: show(len(samples) + at + share))
            warnings |= dict.fromkeys(made.warnings)
            results.append(self.results(made))
        for warning in warnings:
            logging.warning("relievo %s: %s", self.COMMAND, warning)
        return tuple(tensor_of(list(batch)) for batch in zip(*results, strict=True))

    def results(self, made: Any) -> tuple[np.ndarray, ...]:
        """The outputs for one image."""
        return (displayed(made.picture(), made.shown()),)


def sample(count: int) -> list[int]:
    """Images spread over a batch."""
    return sorted({round(at) for at in np.linspace(0, count - 1, min(SAMPLES, count))})


def node(command: str) -> Any:
    """Gives a class the command and the first words of its help."""

    def with_command(cls: type[Node]) -> type[Node]:
        cls.COMMAND = command
        cls.DESCRIPTION = getattr(pyrelievo, command).__doc__.partition("\n")[0]
        return cls

    return with_command


@node("enhance")
class Enhance(Node):
    REQUIRED, OPTIONAL = ("image",), ("normal", "depth", "mask")
    RETURN_TYPES, RETURN_NAMES = ("IMAGE",), ("image",)


@node("relight")
class Relight(Node):
    REQUIRED, OPTIONAL = (), ("normal", "image", "albedo", "depth", "mask")
    RETURN_TYPES, RETURN_NAMES = ("IMAGE",), ("image",)


@node("shape")
class Shape(Node):
    REQUIRED, OPTIONAL = (), ("normal", "depth", "mask")
    RETURN_TYPES = ("IMAGE", "MASK", "MASK", "MASK", "MASK")
    RETURN_NAMES = ("curvature", "convex", "concave", "silhouettes", "creases")
    OUTPUT_TOOLTIPS = (
        "Curvature in grey: brighter than the middle where convex.",
        "Curvature where convex, 0 to 1.",
        "Curvature where concave, 0 to 1.",
        "Edges between a surface and what is behind it.",
        "Edges within a surface.",
    )

    def results(self, made: Any) -> tuple[np.ndarray, ...]:
        shape = pyrelievo.Shape._of(made)
        grey = np.repeat((0.5 + 0.5 * shape.kappa)[..., None], 3, axis=2)
        return grey, np.maximum(shape.kappa, 0), np.maximum(-shape.kappa, 0), shape.silhouette, shape.crease


@node("hatch")
class Hatch(Node):
    REQUIRED, OPTIONAL = (), ("normal", "image", "depth", "mask")
    RETURN_TYPES, RETURN_NAMES = ("IMAGE", "MASK"), ("drawing", "ink")
    OUTPUT_TOOLTIPS = ("The drawing on white paper.", "1 where ink is, 0 for bare paper.")

    def results(self, made: Any) -> tuple[np.ndarray, ...]:
        paper = made.picture()
        return displayed(paper, made.shown()), 1 - paper[..., 0]


NODE_CLASS_MAPPINGS = {f"Relievo{cls.__name__}": cls for cls in (Shape, Enhance, Relight, Hatch)}
NODE_DISPLAY_NAME_MAPPINGS = {name: f"{cls.__name__} (relievo)" for name, cls in NODE_CLASS_MAPPINGS.items()}
