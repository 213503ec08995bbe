"""The extension as users get it: built, installed by Blender from its zip, and enabled."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

# Before bpy is imported: nothing of the user's own Blender is read or changed.
USER = tempfile.TemporaryDirectory()
os.environ["BLENDER_USER_RESOURCES"] = USER.name

import bpy  # noqa: E402

HERE = Path(__file__).parent
SIZE = (160, 120)


def pytest_addoption(parser):
    parser.addoption("--wheel", required=True, help="the wheel of pyrelievo that is bundled")


def pytest_configure(config):
    path = Path(USER.name) / "relievo.zip"
    build = [sys.executable, HERE.parent / "build.py", "-o", path, config.getoption("wheel")]
    subprocess.run(build, check=True)
    bpy.ops.extensions.package_install_files(filepath=str(path), repo="user_default", enable_on_install=True)


@pytest.fixture(scope="session")
def relievo():
    """The extension's module."""
    return sys.modules["bl_ext.user_default.relievo"]


@pytest.fixture
def scene(relievo):
    """A head and a ball under a lamp, with settings at their defaults and every pass that enhance wants."""
    scene = bpy.data.scenes.get("Bust") or make_scene()
    bpy.context.window.scene = scene
    for command in relievo.settings.COMMANDS:
        group = getattr(scene.relievo, command)
        for name in group.bl_rna.properties.keys():
            group.property_unset(name)
    scene.relievo.command = "enhance"
    scene.frame_set(1)
    return scene


@pytest.fixture
def rendered(scene):
    """The scene, rendered."""
    bpy.ops.relievo.switch_passes()
    bpy.ops.render.render(scene=scene.name)
    return scene


def make_scene():
    scene = bpy.data.scenes.new("Bust")
    bpy.context.window.scene = scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = 4
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    bpy.ops.mesh.primitive_monkey_add(size=2, location=(-0.4, 0, 0), rotation=(1.2, 0, 0.3))
    head = bpy.context.object
    bpy.ops.object.shade_smooth()
    # In the second and third frame the head looks elsewhere, so that automatic choices differ.
    head.keyframe_insert("rotation_euler", frame=1)
    head.rotation_euler.z = 1.2
    head.keyframe_insert("rotation_euler", frame=3)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(1.2, 0.4, 0.2))
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.3, 0))
    bpy.context.object.data.energy = 3
    bpy.ops.object.camera_add(location=(0, -4.5, 0.6), rotation=(1.45, 0, 0))
    scene.camera = bpy.context.object
    scene.frame_end = 3
    return scene


@pytest.fixture
def command_line(relievo):
    """Runs the command line of the bundled wheel."""
    import pyrelievo

    environment = os.environ | {"PYTHONPATH": str(Path(pyrelievo.__file__).parents[1])}

    def run(*words):
        line = [sys.executable, "-m", "pyrelievo", *map(str, words), "-q"]
        subprocess.run(line, check=True, env=environment)

    return run
