from pathlib import Path

import numpy as np
import pytest

FIXTURES = Path(__file__).parents[3] / "fixtures"


@pytest.fixture
def bust():
    return str(FIXTURES / "bust.exr")


@pytest.fixture
def ball():
    """Normals, depth and a picture of a ball of 64 pixels, lit from the viewer."""
    y, x = np.mgrid[1:-1:64j, -1:1:64j].astype(np.float32)
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    normal = np.dstack([x, y, z]) * (z > 0)[..., None]
    return {"color": np.dstack([z, z, z]), "normal": normal, "depth": np.where(z > 0, 5 - z, 0)}
