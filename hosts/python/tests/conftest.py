from pathlib import Path

import numpy as np
import OpenEXR
import pytest

FIXTURES = Path(__file__).parents[3] / "fixtures"


@pytest.fixture
def bust():
    return str(FIXTURES / "bust.exr")


def ball_layers():
    """Normals, depth and a picture of a ball of 64 pixels, lit from the viewer."""
    y, x = np.mgrid[1:-1:64j, -1:1:64j].astype(np.float32)
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    normal = np.dstack([x, y, z]) * (z > 0)[..., None]
    return {"color": np.dstack([z, z, z]), "normal": normal, "depth": np.where(z > 0, 5 - z, 0)}


ball = pytest.fixture(ball_layers, name="ball")


def channels_of(path):
    """The channels of all parts of an EXR."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}


def channel_of(channels, end):
    found = [pixels for name, pixels in channels.items() if name == end or name.endswith("." + end)]
    assert len(found) == 1, (end, list(channels))
    return found[0]
