"""Stand-ins for the server and, where it is not installed, for torch."""

import importlib.util
import sys
import types
from pathlib import Path

import numpy as np
import pytest

PACKAGE = Path(__file__).parents[1]
FIXTURES = PACKAGE.parents[1] / "fixtures"


class Tensor:
    """What the nodes use of a tensor, backed by NumPy."""

    def __init__(self, array):
        self.array = array

    def detach(self):
        return self

    def to(self, device, dtype):
        assert device == "cpu"
        return Tensor(self.array.astype(dtype))

    def numpy(self):
        return self.array


try:
    import torch
except ImportError:
    torch = types.ModuleType("torch")
    torch.float32 = np.float32
    torch.from_numpy = Tensor
    sys.modules["torch"] = torch


def read(name):
    """An image of the fixtures as the server loads it."""
    from PIL import Image

    return np.asarray(Image.open(FIXTURES / name).convert("RGB"), np.float32)[None] / 255


class Server:
    """Loads a package of nodes, checks inputs and calls nodes, by the rules of ComfyUI."""

    def __init__(self, folder):
        name = str(folder).replace(".", "_x_")
        spec = importlib.util.spec_from_file_location(name, folder / "__init__.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
        self.nodes = module.NODE_CLASS_MAPPINGS
        self.names = module.NODE_DISPLAY_NAME_MAPPINGS

    def inputs(self, name):
        """The inputs of a node by name: type, options and whether it is required."""
        kinds = self.nodes[name].INPUT_TYPES()
        assert set(kinds) <= {"required", "optional", "hidden"}
        assert not set(kinds["required"]) & set(kinds["optional"])
        return {
            key: (kind, options, group == "required")
            for group in ("required", "optional")
            for key, (kind, options) in kinds[group].items()
        }

    def call(self, name, **given):
        """Calls a node as from a workflow: widgets have their defaults, tensors stand for linked sockets."""
        inputs = self.inputs(name)
        assert set(given) <= set(inputs), set(given) - set(inputs)
        values = {}
        for key, (kind, options, is_required) in inputs.items():
            is_socket = kind in ("IMAGE", "MASK")
            if is_socket and key not in given:
                assert not is_required, f"{key} is missing"
                continue
            value = given.get(key, options.get("default"))
            values[key] = torch.from_numpy(value) if is_socket else self.checked(kind, options, value)
        node = self.nodes[name]
        made = getattr(node(), node.FUNCTION)(**values)
        assert len(made) == len(node.RETURN_TYPES)
        for tensor, kind in zip(made, node.RETURN_TYPES, strict=True):
            array = tensor.numpy()
            assert array.dtype == np.float32 and array.flags.c_contiguous
            assert array.min() >= 0 and array.max() <= 1
            assert array.ndim == 4 and array.shape[3] == 3 if kind == "IMAGE" else array.ndim == 3
        return [tensor.numpy() for tensor in made]

    def run(self, workflow):
        """Runs a workflow in the form of the API; returns what its previews show."""
        made = {}

        def kinds(key):
            name = workflow[key]["class_type"]
            return ("IMAGE", "MASK") if name == "LoadImage" else self.nodes[name].RETURN_TYPES

        def value(kind, given):
            if not isinstance(given, list):
                return given
            key, at = given
            assert kinds(key)[at] == kind
            if key not in made:
                made[key] = outputs(workflow[key])
            return made[key][at]

        def outputs(node):
            name, given = node["class_type"], node["inputs"]
            if name == "LoadImage":
                image = read(given["image"])
                return image, np.zeros(image.shape[:3], np.float32)
            inputs = self.inputs(name)
            # The server refuses a workflow that leaves them out, even where they have a default.
            assert {key for key, (_, _, is_required) in inputs.items() if is_required} <= set(given) <= set(inputs)
            return self.call(name, **{key: value(inputs[key][0], one) for key, one in given.items()})

        shown = [node["inputs"] for node in workflow.values() if node["class_type"] == "PreviewImage"]
        return [value("IMAGE", inputs["images"]) for inputs in shown]

    @staticmethod
    def checked(kind, options, value):
        if isinstance(kind, list):
            assert value in kind
            return value
        value = {"INT": int, "FLOAT": float, "STRING": str, "BOOLEAN": bool}[kind](value)
        assert "min" not in options or value >= options["min"]
        assert "max" not in options or value <= options["max"]
        return value


@pytest.fixture(scope="session")
def server():
    return Server(PACKAGE)


@pytest.fixture
def ball():
    """A batch of one: a picture of a ball, in sRGB, and its normal map, with black around it."""
    y, x = np.mgrid[1:-1:64j, -1:1:64j].astype(np.float32)
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    is_ball = (z > 0)[..., None]
    image = np.where(is_ball, 0.2 + 0.5 * np.dstack([z, z, 0.5 + 0.5 * x]), 0.3).astype(np.float32)
    normal = np.where(is_ball, 0.5 + 0.5 * np.dstack([x, y, z]), 0).astype(np.float32)
    return {"image": image[None], "normal": normal[None]}
