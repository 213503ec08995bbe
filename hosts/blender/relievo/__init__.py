"""Relievo in Blender: brings out the shape of surfaces in renders, from their passes.

`settings` makes properties of pyrelievo's table, `passes` reads renders, `results` shows what is made of them, and
`operators` and `panels` are what users meet. `job` keeps Blender's window alive meanwhile.
"""

import bpy

from . import operators, panels, settings

CLASSES = (*operators.CLASSES, *panels.CLASSES)


def register() -> None:
    """Adds everything to Blender."""
    settings.register()
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.TOPBAR_MT_render.append(panels.draw_menu)


def unregister() -> None:
    """Takes it away."""
    bpy.types.TOPBAR_MT_render.remove(panels.draw_menu)
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
    settings.unregister()
