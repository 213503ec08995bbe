"""Operators: what the menu and the sidebar do."""

import time
from collections.abc import Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, ClassVar

import bpy
import numpy as np
import pyrelievo
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper
from pyrelievo import _relievo
from pyrelievo._settings import FLAG

from . import passes, results, settings
from .job import Job

#: Errors that are the user's to mend: of settings, files, memory, and of what Blender is asked for.
MENDABLE = (ValueError, TypeError, OSError, RuntimeError, MemoryError)

#: How often a window is asked whether work is done, in seconds.
TICK = 0.05

#: How many frames of an animation everything automatic is chosen from, as on the command line.
SAMPLES = 5

#: The file of a frame's passes, with its number.
PASSES = "passes.####.exr"

Steps = Generator[float, None, None]


def sentence(error: BaseException, path: Path | None = None) -> str:
    """An error as a sentence of the sidebar: with the names of its settings, and without temporary files."""
    said = " ".join(str(error).split()) or type(error).__name__
    if path is not None:
        said = said.replace(str(path), "the render")
    said = FLAG.sub(lambda flag: flag[1].replace("-", " "), said)
    return f"{said[0].upper()}{said[1:]}"


class Alone:
    """An operator that reads the last render. Only one may at a time: another would render it anew meanwhile."""

    #: The label of the one at work.
    at_work: ClassVar[str | None] = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether none is at work."""
        if Alone.at_work is not None:
            cls.poll_message_set(f"{Alone.at_work} is still at work: wait for it, or cancel it with Esc")
        return Alone.at_work is None


class Stepped(Alone):
    """An operator that works in steps: in a window the steps are those of a timer, and Esc cancels between them."""

    def steps(self, context: bpy.types.Context) -> Steps:
        """The work: gives the share that is done, at every step. It cleans up in `finally`."""
        raise NotImplementedError

    def warn(self, warnings: Iterable[str]) -> None:
        """Shows warnings."""
        for said in warnings:
            self.report({"WARNING"}, said)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Does all of it at once."""
        Alone.at_work = self.bl_label
        try:
            for _ in self.steps(context):
                time.sleep(TICK / 10)
        except MENDABLE as error:
            self.report({"ERROR"}, sentence(error))
            return {"CANCELLED"}
        finally:
            Alone.at_work = None
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Starts the work, and leaves the window alive."""
        if context.window is None or bpy.app.background:
            return self.execute(context)
        Alone.at_work = self.bl_label
        self._steps = self.steps(context)
        manager = context.window_manager
        self._timer = manager.event_timer_add(TICK, window=context.window)
        manager.modal_handler_add(self)
        manager.progress_begin(0, 100)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """One step, at every tick."""
        if event.type == "ESC":
            self._steps.close()
            self.report({"INFO"}, "Cancelled")
            return self._end(context, {"CANCELLED"})
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            context.window_manager.progress_update(100 * next(self._steps))
        except StopIteration:
            return self._end(context, {"FINISHED"})
        except MENDABLE as error:
            self.report({"ERROR"}, sentence(error))
            return self._end(context, {"CANCELLED"})
        except Exception:
            # A fault of the extension must not keep it from being used again.
            self._end(context, {"CANCELLED"})
            raise
        return {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Ends the work; Blender asks for it too, where another file is opened meanwhile."""
        self._steps.close()
        Alone.at_work = None

    def _end(self, context: bpy.types.Context, result: set[str]) -> set[str]:
        Alone.at_work = None
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        return result


def made_of(scene: bpy.types.Scene, recipe: pyrelievo.Recipe, path: Path, number: int | None = None) -> Any:
    """Steps that make what a recipe makes of a file of passes, with its number if it is one of an animation; they return
    results, and warnings."""
    has_alpha = scene.render.film_transparent
    job = Job(lambda progress: results.results_of(recipe, path, number, has_alpha, progress))
    file = path if number is None else passes_path(path.parent, number)
    try:
        made, warnings = yield from job.steps()
    except MENDABLE as error:
        off = passes.missing(scene, passes.SURFACE)
        advice = "; switch the needed passes on in the sidebar, and render again" if off else ""
        raise ValueError(sentence(error, file) + advice) from error
    return made, [sentence(Warning(said), file) for said in warnings]


def made_of_render(scene: bpy.types.Scene, recipe: pyrelievo.Recipe) -> Any:
    """Steps that make what a recipe makes of the last render."""
    with saved_render(scene) as path:
        return (yield from made_of(scene, recipe, path))


@contextmanager
def saved_render(scene: bpy.types.Scene) -> Iterator[Path]:
    """The file of the last render's passes, as long as it is needed."""
    with passes.temporary_folder() as folder:
        path = folder / "passes.exr"
        passes.save_passes(scene, path)
        yield path


class RELIEVO_OT_bring_out(Stepped, bpy.types.Operator):
    """Bring out the shape in the last render, and show it in the Image Editor"""

    bl_idname = "relievo.bring_out"
    bl_label = "Bring Out Shape"
    bl_options = {"REGISTER"}

    def steps(self, context: bpy.types.Context) -> Steps:
        made, warnings = yield from made_of_render(context.scene, settings.recipe_of(context.scene))
        self.warn(warnings)
        images = [results.image_of(result) for result in made]
        if results.show(context, images[0]) is None:
            self.report({"INFO"}, f"The result is the image {images[0].name}")


@contextmanager
def cancellations() -> Iterator[list[Any]]:
    """Renders that are cancelled meanwhile."""
    found: list[Any] = []

    def note(*_: Any) -> None:
        found.append(True)

    bpy.app.handlers.render_cancel.append(note)
    try:
        yield found
    finally:
        bpy.app.handlers.render_cancel.remove(note)


class RELIEVO_OT_bring_out_animation(Stepped, bpy.types.Operator):
    """Render every frame, bring out the shape in it, and write the result to the folder. Esc cancels"""

    bl_idname = "relievo.bring_out_animation"
    bl_label = "Bring Out Shape of Animation"
    bl_options = {"REGISTER"}

    def steps(self, context: bpy.types.Context) -> Steps:
        scene = context.scene
        folder = output_folder(scene)
        frames = list(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
        samples = spread(frames)
        recipe = settings.recipe_of(scene)
        said: dict[str, None] = {}
        before = scene.frame_current, scene.frame_subframe
        with ExitStack() as stack:
            stack.callback(lambda: scene.frame_set(before[0], subframe=before[1]))
            cancelled = stack.enter_context(cancellations())
            there = stack.enter_context(passes.temporary_folder())

            def rendered(number: int) -> Steps:
                yield from render(context, scene, number)
                if cancelled:
                    raise ValueError(f"the render of frame {number} was cancelled")
                passes.save_passes(scene, passes_path(there, number))

            for number in samples:
                yield from within(rendered(number), 0, 0)
            recipe = yield from within(chosen(recipe, there / PASSES, samples), 0, 0)
            for at, number in enumerate(frames):
                start, share = at / len(frames), 1 / len(frames)
                if number not in samples:
                    yield from within(rendered(number), start, 0)
                made, warnings = yield from within(made_of(scene, recipe, there / PASSES, number), start, share)
                said.update(dict.fromkeys(warnings))
                for result in made:
                    results.save(result, results.image_of(result), scene, f"{folder / result.name}_{number:04d}")
                passes_path(there, number).unlink()
        self.warn(said)
        self.report({"INFO"}, f"{len(frames)} frames are in {folder}")


def output_folder(scene: bpy.types.Scene) -> Path:
    """The folder of an animation's results."""
    folder = scene.relievo.folder.strip()
    if not folder:
        raise ValueError("the folder is empty; name one for the frames")
    if folder.startswith("//") and not bpy.data.filepath:
        raise ValueError(f"the folder {folder} is beside the .blend, which has no place yet: save it, or name another")
    return Path(bpy.path.abspath(folder))


def spread(frames: list[int]) -> list[int]:
    """A few frames, spread over all."""
    if not frames:
        raise ValueError("the scene's frame range is empty")
    at = np.linspace(0, len(frames) - 1, min(SAMPLES, len(frames))).round().astype(int)
    return [frames[i] for i in at]


def passes_path(folder: Path, number: int) -> Path:
    """The file of a frame's passes."""
    return folder / PASSES.replace("####", f"{number:04d}")


def render(context: bpy.types.Context, scene: bpy.types.Scene, number: int) -> Steps:
    """Renders a frame, in a job of Blender's where there is a window."""
    scene.frame_set(number)
    if bpy.app.background:
        bpy.ops.render.render(scene=scene.name)
        return
    view = context.preferences.view
    with passes.restored(view):
        # No window pops up at every frame.
        view.render_display_type = "NONE"
        bpy.ops.render.render("INVOKE_DEFAULT", scene=scene.name)
    yield 0.0
    while bpy.app.is_job_running("RENDER"):
        yield 0.0


def chosen(recipe: pyrelievo.Recipe, pattern: Path, frames: list[int]) -> Any:
    """Steps that choose everything automatic once for all frames; they return a recipe with the choices."""
    engine = pyrelievo.Engine()
    job = Job(lambda progress: engine.choose(recipe.command, recipe.settings, str(pattern), frames, progress))
    try:
        values, _ = yield from job.steps()
    except MENDABLE as error:
        raise ValueError(sentence(error, passes_path(pattern.parent, frames[0]))) from error
    return pyrelievo.Recipe.parse(_relievo.recipe(recipe.command, values))


def within(steps: Steps, start: float, share: float) -> Any:
    """Steps of a part of the work, which give the share of the whole; they return what the part returns."""
    try:
        while True:
            yield start + share * next(steps)
    except StopIteration as end:
        return end.value
    finally:
        steps.close()


class RELIEVO_OT_curvature(Stepped, bpy.types.Operator):
    """Make an image of the curvature for the compositor: 1 where convex, -1 where concave, 0 where flat"""

    bl_idname = "relievo.curvature"
    bl_label = "Curvature as an Image"
    bl_options = {"REGISTER"}

    def steps(self, context: bpy.types.Context) -> Steps:
        scene = context.scene
        own = settings.given(scene, scene.relievo.command)
        shape = {name: value for name, value in own.items() if name in settings.shown_rows("shape")}
        made, warnings = yield from made_of_render(scene, pyrelievo.Recipe("shape", **shape))
        self.warn(warnings)
        results.show(context, results.image_of(made[0]))


def drawn_lines(scene: bpy.types.Scene) -> str:
    """The last render, drawn in lines: the text of an SVG."""
    recipe = pyrelievo.Recipe("hatch", **settings.given(scene, "hatch"))
    with saved_render(scene) as path:
        try:
            return recipe(pyrelievo.load(path)).svg()
        except MENDABLE as error:
            raise ValueError(sentence(error, path)) from error


class Plain:
    """An operator that works at once, and whose errors are sentences."""

    def work(self, context: bpy.types.Context) -> None:
        """The work."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Does the work."""
        try:
            self.work(context)
        except MENDABLE as error:
            self.report({"ERROR"}, sentence(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class RELIEVO_OT_save_svg(Alone, Plain, ExportHelper, bpy.types.Operator):
    """Draw the last render in lines, as an SVG"""

    bl_idname = "relievo.save_svg"
    bl_label = "Drawing as SVG"

    filename_ext = ".svg"
    filter_glob: StringProperty(default="*.svg", options={"HIDDEN"})

    def work(self, context: bpy.types.Context) -> None:
        Path(self.filepath).write_text(drawn_lines(context.scene), encoding="utf-8")


class RELIEVO_OT_grease_pencil(Alone, Plain, bpy.types.Operator):
    """Draw the last render in lines, as Grease Pencil"""

    bl_idname = "relievo.grease_pencil"
    bl_label = "Drawing as Grease Pencil"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, context: bpy.types.Context) -> None:
        text = drawn_lines(context.scene)
        with passes.temporary_folder() as folder:
            path = folder / "Relievo drawing.svg"
            path.write_text(text, encoding="utf-8")
            with view_3d(context):
                importer()(filepath=str(path), directory=str(folder), files=[{"name": path.name}])


def importer() -> Any:
    """Blender's operator that reads an SVG into Grease Pencil."""
    for name in ("grease_pencil_import_svg", "gpencil_import_svg"):
        if name in dir(bpy.ops.wm):
            return getattr(bpy.ops.wm, name)
    raise ValueError("this Blender reads no SVG into Grease Pencil; save the SVG instead")


def view_3d(context: bpy.types.Context) -> Any:
    """A context in a 3D view, where Grease Pencil is placed."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                region = next(region for region in area.regions if region.type == "WINDOW")
                return context.temp_override(window=window, area=area, region=region)
    raise ValueError("no 3D view is open, where Grease Pencil would be drawn; open one, and try again")


class RELIEVO_OT_switch_passes(bpy.types.Operator):
    """Switch on the passes that the command is best given, in all view layers that are rendered"""

    bl_idname = "relievo.switch_passes"
    bl_label = "Switch Passes On"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        off = passes.missing(context.scene, passes.needed(context.scene))
        for layer, flag in off:
            setattr(layer, flag, True)
        self.report({"INFO"}, f"{len(off)} passes are switched on; render again")
        return {"FINISHED"}


class RELIEVO_OT_load_recipe(Plain, ImportHelper, bpy.types.Operator):
    """Take over the command and settings of a recipe"""

    bl_idname = "relievo.load_recipe"
    bl_label = "Load Recipe"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".toml"
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})

    def work(self, context: bpy.types.Context) -> None:
        settings.apply_recipe(context.scene, pyrelievo.Recipe.read(self.filepath))


class RELIEVO_OT_save_recipe(Plain, ExportHelper, bpy.types.Operator):
    """Save the command and its settings as a recipe, which relievo run reads too"""

    bl_idname = "relievo.save_recipe"
    bl_label = "Save Recipe"

    filename_ext = ".toml"
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})

    def work(self, context: bpy.types.Context) -> None:
        settings.recipe_of(context.scene).write(self.filepath)


CLASSES = (
    RELIEVO_OT_bring_out,
    RELIEVO_OT_bring_out_animation,
    RELIEVO_OT_curvature,
    RELIEVO_OT_save_svg,
    RELIEVO_OT_grease_pencil,
    RELIEVO_OT_switch_passes,
    RELIEVO_OT_load_recipe,
    RELIEVO_OT_save_recipe,
)
