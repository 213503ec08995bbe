"""Properties are pyrelievo's table, and recipes are those of the command line."""

from pathlib import Path

import bpy
import numpy as np
import pyrelievo
import pytest
from pyrelievo import _relievo
from pyrelievo._settings import rows, text

COMMANDS = _relievo.commands()

FIXTURE = Path(__file__).parents[3] / "fixtures" / "bust.exr"


@pytest.mark.parametrize("command", COMMANDS)
def test_properties_are_the_table(scene, relievo, command):
    group = getattr(scene.relievo, command)
    known = group.bl_rna.properties
    raw = {row["name"]: row for row in _relievo.settings(command)}
    shown = {name: row for name, row in rows(command).items() if name not in ("write", "sample_frames")}
    assert len(shown) > 30
    for name, row in shown.items():
        of = known[name]
        assert of.description.startswith(row.help), name
        match row.kind:
            case "number":
                # Properties are 32 bits.
                ends = np.float32(raw[row.name]["range"])
                np.testing.assert_array_equal(np.float32([of.soft_min, of.soft_max]), ends)
                assert (of.type == "INT") == raw[row.name]["whole"], name
                if isinstance(row.default, (int, float)):
                    assert np.float32(of.default) == np.float32(row.default), name
                else:
                    assert getattr(group, f"{name}_unset"), name
                    assert known[f"{name}_unset"].name == (row.words or ["auto"])[0], name
            case "choice":
                assert [item.identifier for item in of.enum_items] == row.words
                assert of.default == row.default
            case "switch":
                assert of.default is False
            case _:
                assert of.default == ("" if row.default is None else text(row.default))
    assert relievo.settings.given(scene, command) == {}


def test_the_sidebar_shows_every_setting_once(relievo):
    for command in COMMANDS:
        first, more = (relievo.panels.groups_of(command, is_common) for is_common in (True, False))
        shown = [row.keyword for groups in (first, more) for rows in groups.values() for row in rows]
        assert sorted(shown) == sorted(relievo.settings.shown_rows(command))
        assert 3 <= sum(map(len, first.values())) < 0.25 * len(shown)
        assert all(hasattr(bpy.types, "RELIEVO_PT_" + heading.lower().replace(" ", "_")) for heading in more)


def test_only_changes_are_given(scene, relievo):
    own = scene.relievo.enhance
    own.scaling = 0.7
    own.exposure_unset = False
    own.exposure = 1.5
    own.object = "Head; !Ball"
    # 0.7 in 32 bits is 0.699999988: what was typed is given.
    assert relievo.settings.given(scene, "enhance") == {
        "scaling": 0.7,
        "exposure": 1.5,
        "object": ["Head", "!Ball"],
    }


def test_recipes_make_a_round_trip(scene, relievo, tmp_path):
    path = tmp_path / "look.toml"
    own = scene.relievo.relight
    scene.relievo.command = "relight"
    own.light, own.warp, own.thin, own.environment_gain_unset = "135,40; 20,30,1,0,0", 6.5, True, False
    own.environment_gain = 0.3
    before = relievo.settings.given(scene, "relight")
    assert len(before) == 4
    bpy.ops.relievo.save_recipe(filepath=str(path))
    own.light, own.warp, own.thin, own.environment_gain, own.samples_unset = "", 1, False, 7, False
    scene.relievo.command = "map"
    bpy.ops.relievo.load_recipe(filepath=str(path))
    assert scene.relievo.command == "relight"
    assert relievo.settings.given(scene, "relight") == before


def test_recipes_of_the_command_line_are_taken(scene, relievo, command_line, tmp_path):
    path = tmp_path / "look.toml"
    command_line("hatch", FIXTURE, "--key-share", "0.5", "--save-recipe", path, "--lines-only", "--stroke-width", 3)
    bpy.ops.relievo.load_recipe(filepath=str(path))
    assert relievo.settings.given(scene, "hatch") == {"key_share": 0.5, "lines_only": True, "stroke_width": 3.0}


def test_a_recipe_that_no_control_can_show_changes_nothing(scene, relievo, tmp_path):
    path = tmp_path / "look.toml"
    pyrelievo.Recipe("shape", scale=[2, 6], foreshortening=1).write(path)
    with pytest.raises(RuntimeError, match="Scale is 2,6 in the recipe; the sidebar takes one number"):
        bpy.ops.relievo.load_recipe(filepath=str(path))
    assert scene.relievo.command == "enhance"
    assert relievo.settings.given(scene, "shape") == {}
