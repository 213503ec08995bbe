"""Prints what Blender shows of the layer `relievo` of EXR files: its passes, and what they hold at a pixel.

    blender -b --factory-startup -P show_layers.py -- X Y FILE...

Or by the Python of the module `bpy`. Lines are `version N`, `file FILE`, `pass NAME`, and `value NAME R G B`; X from the left, Y from the
bottom. The compositor of Blender 5 is made otherwise, and there passes are only named.
"""

import os
import sys
import tempfile

import bpy


def tree_of(scene):
    if bpy.app.version < (5, 0, 0):
        scene.use_nodes = True
        return scene.node_tree
    scene.compositing_node_group = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
    return scene.compositing_node_group


def values(tree, shown, x, y, folder):
    """What each output of the node `shown` holds at a pixel, by way of files in a folder."""
    written = tree.nodes.new("CompositorNodeOutputFile")
    written.base_path = folder
    written.format.file_format, written.format.color_depth = "OPEN_EXR", "32"
    written.file_slots.clear()
    tree.nodes.new("CompositorNodeComposite")
    names = [output.name for output in shown.outputs if output.enabled]
    for name in names:
        written.file_slots.new(name)
        tree.links.new(shown.outputs[name], written.inputs[name])
    bpy.ops.render.render()
    for name in names:
        image = bpy.data.images.load(os.path.join(written.base_path, name + "0001.exr"))
        image.colorspace_settings.name = "Non-Color"
        at = 4 * (y * image.size[0] + x)
        print("value", name, *image.pixels[at : at + 3])


print("version", bpy.app.version[0])
x, y, *files = sys.argv[sys.argv.index("--") + 1 :]
for file in files:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    tree = tree_of(scene)
    tree.nodes.clear()
    image = bpy.data.images.load(file)
    shown = tree.nodes.new("CompositorNodeImage")
    shown.image = image
    print("file", file)
    if shown.has_layers:
        shown.layer = "relievo"
    for output in shown.outputs:
        if output.enabled:
            print("pass", output.name)
    if bpy.app.version < (5, 0, 0):
        scene.render.resolution_percentage = 100
        for name, value in zip(("resolution_x", "resolution_y"), (480, 360)):
            setattr(scene.render, name, value)
        with tempfile.TemporaryDirectory() as folder:
            values(tree, shown, int(x), int(y), folder)
