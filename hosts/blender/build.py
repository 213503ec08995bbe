"""Makes the extension: a zip with the wheels of pyrelievo that it's given, checked by Blender's own validator.

    python build.py -o relievo.zip target/python/wheels/*.whl

Runs in a Python that has `bpy`; else `--blender-ext` names Blender's scripts/addons_core/bl_pkg/cli/blender_ext.py.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).parent / "relievo"
LICENCE = Path(__file__).parents[2] / "LICENSE-MIT"

#: Systems and machines of Blender, by what the names of wheels have for them.
SYSTEMS = {"linux": "linux", "macosx": "macos", "win": "windows"}
MACHINES = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64", "arm64": "arm64"}


def platform_of(wheel: Path) -> str:
    """The platform of a wheel, as Blender calls it."""
    tag = wheel.stem.split("-")[-1]
    found = re.search(f"({'|'.join(SYSTEMS)})[0-9_]*_({'|'.join(MACHINES)})$", tag)
    if not found:
        raise SystemExit(f"{wheel.name}: Blender has no platform {tag}")
    return f"{SYSTEMS[found[1]]}-{MACHINES[found[2]]}"


def versions_of(wheels: list[Path]) -> str:
    """The version of all wheels, which is the extension's."""
    versions = {wheel.name.split("-")[1] for wheel in wheels}
    if len(versions) != 1:
        raise SystemExit(f"wheels of one version are needed; these have {', '.join(sorted(versions)) or 'none'}")
    return versions.pop()


def bundled_name(wheel: Path) -> str:
    """The name of a wheel in the zip. Blender 4.3 takes one for 3.10 and later for one of 3.10: its own 3.11 is named."""
    return wheel.name.replace("-cp310-abi3-", "-cp310.cp311-abi3-")


def write_source(folder: Path, wheels: list[Path]) -> None:
    """The extension's files with their wheels, and a manifest that lists them."""
    shutil.copytree(SOURCE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(LICENCE, folder)
    (folder / "wheels").mkdir()
    for wheel in wheels:
        shutil.copy(wheel, folder / "wheels" / bundled_name(wheel))
    quoted = [f'  "./wheels/{bundled_name(wheel)}",' for wheel in wheels]
    platforms = ", ".join(f'"{platform}"' for platform in sorted(map(platform_of, wheels)))
    lines = [f'version = "{versions_of(wheels)}"', f"platforms = [{platforms}]", "wheels = [", *quoted, "]"]
    manifest = folder / "blender_manifest.toml"
    own = [line for line in manifest.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    manifest.write_text("\n".join([*lines, *own, ""]), encoding="utf-8")


def blender_ext() -> Path:
    """Blender's tool for extensions, in the scripts of the `bpy` of this Python."""
    import bpy

    scripts = Path(bpy.utils.system_resource("SCRIPTS"))
    found = list(scripts.glob("addons*/bl_pkg/cli/blender_ext.py"))
    if not found:
        raise SystemExit(f"{scripts} has no blender_ext.py; name it with --blender-ext")
    return found[0]


def main() -> None:
    """Builds and validates."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheels", nargs="+", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--blender-ext", type=Path)
    typed = parser.parse_args()
    tool = [sys.executable, typed.blender_ext or blender_ext()]
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "relievo"
        write_source(source, typed.wheels)
        built = ["build", "--source-dir", source, "--output-filepath", typed.output]
        subprocess.run([*tool, *built], check=True)
    subprocess.run([*tool, "validate", typed.output], check=True)


if __name__ == "__main__":
    main()
