"""The sidebar of the Image Editor, and the entries of the Render menu."""

from functools import cache
from typing import Any

import bpy
from pyrelievo._settings import INPUTS, OF_FILES, Row

from . import passes, settings
from .operators import (
    RELIEVO_OT_bring_out,
    RELIEVO_OT_bring_out_animation,
    RELIEVO_OT_curvature,
    RELIEVO_OT_grease_pencil,
    RELIEVO_OT_load_recipe,
    RELIEVO_OT_save_recipe,
    RELIEVO_OT_save_svg,
    RELIEVO_OT_switch_passes,
)


@cache
def groups_of(command: str, is_common: bool) -> dict[str, list[Row]]:
    """The settings that most users need, or the others, by the headings of the table.

    Passes are found by themselves, so their settings are among the others.
    """
    groups: dict[str, list[Row]] = {}
    for row in settings.shown_rows(command).values():
        if (row.common and row.group not in (INPUTS, *OF_FILES)) == is_common:
            groups.setdefault(row.group, []).append(row)
    return groups


def draw_setting(layout: Any, group: Any, row: Row, number: settings.Slider | None) -> None:
    """One control."""
    if number is None or number.unset is None:
        layout.prop(group, row.keyword, slider=number is not None)
        return
    unset = settings.unset_of(row.keyword)
    line = layout.row(heading=settings.label_of(row))
    line.prop(group, unset)
    value = line.row()
    value.active = not getattr(group, unset)
    value.prop(group, row.keyword, text="", slider=True)


def draw_settings(layout: Any, settings_of_scene: Any, rows: list[Row]) -> None:
    """The controls of some settings, one below the other."""
    command = settings_of_scene.command
    numbers = settings.sliders(command)
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    for row in rows:
        draw_setting(column, getattr(settings_of_scene, command), row, numbers.get(row.keyword))


class Sidebar:
    """A panel in the sidebar of the Image Editor."""

    bl_space_type = "IMAGE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Relievo"


class RELIEVO_PT_main(Sidebar, bpy.types.Panel):
    """What is made of the render, and the settings that decide how it looks"""

    bl_idname = "RELIEVO_PT_main"
    bl_label = "Relievo"

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene = self.layout, context.scene
        layout.prop(scene.relievo, "command", text="")
        column = layout.column(align=True)
        column.scale_y = 1.3
        column.operator(RELIEVO_OT_bring_out.bl_idname, icon="RENDER_STILL")
        off = passes.missing(scene, passes.needed(scene))
        if off:
            column = layout.column(align=True)
            column.label(text=f"{len(off)} useful passes are off", icon="INFO")
            column.operator(RELIEVO_OT_switch_passes.bl_idname)
        for heading, rows in groups_of(scene.relievo.command, True).items():
            layout.label(text=heading)
            draw_settings(layout, scene.relievo, rows)
        line = layout.row(align=True)
        line.operator(RELIEVO_OT_load_recipe.bl_idname, icon="IMPORT")
        line.operator(RELIEVO_OT_save_recipe.bl_idname, icon="EXPORT")


class RELIEVO_PT_more(Sidebar, bpy.types.Panel):
    """All other settings, under the headings that the command line has"""

    bl_idname = "RELIEVO_PT_more"
    bl_parent_id = RELIEVO_PT_main.bl_idname
    bl_label = "More"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        pass


class RELIEVO_PT_results(Sidebar, bpy.types.Panel):
    """Animations, drawings in lines, and images for the compositor"""

    bl_idname = "RELIEVO_PT_results"
    bl_parent_id = RELIEVO_PT_main.bl_idname
    bl_label = "Results"

    def draw(self, context: bpy.types.Context) -> None:
        layout, own = self.layout, context.scene.relievo
        column = layout.column(align=True)
        column.prop(own, "folder", text="")
        column.operator(RELIEVO_OT_bring_out_animation.bl_idname, icon="RENDER_ANIMATION")
        layout.operator(RELIEVO_OT_curvature.bl_idname, icon="NODE_COMPOSITING")
        if own.command == "hatch":
            column = layout.column(align=True)
            column.operator(RELIEVO_OT_save_svg.bl_idname, icon="EXPORT")
            column.operator(RELIEVO_OT_grease_pencil.bl_idname, icon="GREASEPENCIL")


def panel_of(heading: str) -> type:
    """The panel of a heading, below *more*."""

    def poll(cls: type, context: bpy.types.Context) -> bool:
        return heading in groups_of(context.scene.relievo.command, False)

    def draw(self: Any, context: bpy.types.Context) -> None:
        own = context.scene.relievo
        draw_settings(self.layout, own, groups_of(own.command, False)[heading])

    name = "RELIEVO_PT_" + heading.lower().replace(" ", "_")
    members = {
        "bl_idname": name,
        "bl_label": heading,
        "bl_parent_id": RELIEVO_PT_more.bl_idname,
        "bl_options": {"DEFAULT_CLOSED"},
        "poll": classmethod(poll),
        "draw": draw,
    }
    return type(name, (Sidebar, bpy.types.Panel), members)


HEADINGS = dict.fromkeys(heading for command in settings.COMMANDS for heading in groups_of(command, False))
CLASSES = (RELIEVO_PT_main, RELIEVO_PT_results, RELIEVO_PT_more, *map(panel_of, HEADINGS))


def draw_menu(self: Any, context: bpy.types.Context) -> None:
    """The entries of the Render menu."""
    self.layout.separator()
    self.layout.operator(RELIEVO_OT_bring_out.bl_idname)
    self.layout.operator(RELIEVO_OT_bring_out_animation.bl_idname)
