"""Settings of the commands as properties of a scene, made from pyrelievo's own table."""

import math
from functools import cache
from typing import Any, NamedTuple

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from pyrelievo import Recipe, _relievo
from pyrelievo._settings import Row, rows, text

#: Settings of files and of sequences on disk, which images and animations here don't have.
OF_DISK = ("write", "sample_frames")

#: Paths may be beside the .blend, which Blender asks to be told from 4.5 on.
PATH = {"options": {"PATH_SUPPORTS_BLEND_RELATIVE"}} if bpy.app.version >= (4, 5) else {}

#: Between the values of a setting that may be given several times.
BETWEEN = ";"


class Slider(NamedTuple):
    """A number as a control."""

    #: Where the control starts.
    start: float
    #: What a checkbox beside it says, which leaves it to a word or the command; None without one.
    unset: str | None
    is_unset: bool


@cache
def shown_rows(command: str) -> dict[str, Row]:
    """The settings of a command that have a control."""
    return {name: row for name, row in rows(command).items() if name not in OF_DISK}


@cache
def sliders(command: str) -> dict[str, Slider]:
    """The settings of a command that are numbers, by keyword."""
    return {name: slider(row) for name, row in shown_rows(command).items() if row.kind == "number"}


def slider(row: Row) -> Slider:
    """A number of the table as a control."""
    first, last = row.range
    is_given = isinstance(row.default, (int, float))
    middle = math.sqrt(first * last) if row.logarithmic else (first + last) / 2
    start = row.default if is_given else middle
    # Without a word of its own, a number that isn't given is chosen by the command all the same.
    unset = None if is_given and not row.words else (*row.words, "auto")[0]
    return Slider(round(start) if row.whole else start, unset, not is_given)


def unset_of(keyword: str) -> str:
    """The property of the checkbox that leaves a number to a word, or to the command."""
    return f"{keyword}_unset"


def label_of(row: Row) -> str:
    """The label of a setting."""
    words = row.name.replace("-", " ")
    return f"{words[0].upper()}{words[1:]}" + (f" ({row.unit})" if row.unit else "")


def number_property(row: Row, start: float) -> Any:
    """The property of a number, whose range is that of a slider: further values can be typed."""
    first, last = row.range
    said = {"name": label_of(row), "description": row.help}
    if row.whole:
        return IntProperty(default=int(start), soft_min=int(first), soft_max=int(last), **said)
    finest = first if first > 0 else (last - first) / 100
    # In hundredths: a click on an arrow is a hundredth of the range.
    shown = {"precision": min(6, max(2, math.ceil(-math.log10(finest)))), "step": last - first}
    return FloatProperty(default=start, soft_min=first, soft_max=last, **shown, **said)


def text_property(row: Row) -> Any:
    """The property of a text; a file has a button that opens the file browser."""
    several = f". Several with {BETWEEN} between them" if row.repeatable else ""
    form = f" [{row.form}]" if row.form else ""
    default = "" if row.default is None else text(row.default)
    said = {"name": label_of(row), "description": f"{row.help}{form}{several}", "default": default}
    return StringProperty(subtype="FILE_PATH", **PATH, **said) if row.form == "FILE" else StringProperty(**said)


def properties(command: str) -> dict[str, Any]:
    """The properties of a command."""
    made = {}
    for keyword, row in shown_rows(command).items():
        said = {"name": label_of(row), "description": row.help}
        match row.kind:
            case "number":
                start, unset, is_unset = sliders(command)[keyword]
                made[keyword] = number_property(row, start)
                if unset is not None:
                    made[unset_of(keyword)] = BoolProperty(name=unset, description=row.help, default=is_unset)
            case "choice":
                made[keyword] = EnumProperty(items=[(word, word, "") for word in row.words], default=row.default, **said)
            case "switch":
                made[keyword] = BoolProperty(default=row.default, **said)
            case _:
                made[keyword] = text_property(row)
    return made


def group_class(command: str) -> type:
    """The property group of a command."""
    name = f"Relievo{command.capitalize()}"
    return type(name, (bpy.types.PropertyGroup,), {"__annotations__": properties(command)})


COMMANDS = tuple(_relievo.commands())
GROUPS = {command: group_class(command) for command in COMMANDS}


class RelievoSettings(bpy.types.PropertyGroup):
    """What a scene is made into: a command, and the settings of each."""

    command: EnumProperty(
        name="Command",
        description="What is made of the render",
        items=[(command, command.capitalize(), "") for command in COMMANDS],
        default="enhance",
    )
    folder: StringProperty(
        name="Folder",
        description="Where the frames of an animation are written",
        default="//relievo/",
        subtype="DIR_PATH",
        **PATH,
    )


RelievoSettings.__annotations__ |= {command: PointerProperty(type=group) for command, group in GROUPS.items()}


def value_of(row: Row, number: Slider | None, group: Any) -> Any:
    """The value of a setting, as pyrelievo takes it; None where its default is left."""
    value = getattr(group, row.keyword)
    if number is not None:
        if number.unset is not None and getattr(group, unset_of(row.keyword)):
            value = row.words[0] if row.words else None
        elif not row.whole:
            # The shortest number that is the same in the 32 bits of a property.
            value = float(str(np.float32(value)))
    elif row.repeatable:
        parts = [resolved(part.strip()) for part in value.split(BETWEEN)]
        value = [part for part in parts if part] or None
    elif row.kind == "text":
        value = resolved(value.strip()) or None
    is_default = value is None or (row.default is not None and row.texts(value) == row.texts(row.default))
    return None if is_default else value


def resolved(value: str) -> str:
    """A path beside the .blend as one of the system; other texts stay."""
    return bpy.path.abspath(value) if value.startswith("//") else value


def given(scene: bpy.types.Scene, command: str) -> dict[str, Any]:
    """The settings of a command that differ from their defaults."""
    group, numbers = getattr(scene.relievo, command), sliders(command)
    values = {name: value_of(row, numbers.get(name), group) for name, row in shown_rows(command).items()}
    return {name: value for name, value in values.items() if value is not None}


def recipe_of(scene: bpy.types.Scene) -> Recipe:
    """The command and settings of a scene as a recipe."""
    command = scene.relievo.command
    return Recipe(command, **given(scene, command))


def apply_recipe(scene: bpy.types.Scene, recipe: Recipe) -> None:
    """Takes over a recipe: its settings as it has them, and defaults for the others.

    Raises ValueError, and changes nothing, for values that no control can show.
    """
    texts: dict[str, list[str]] = {}
    known, numbers = shown_rows(recipe.command), sliders(recipe.command)
    keywords = {row.name: keyword for keyword, row in known.items()}
    for name, value in recipe.settings:
        if name in keywords:
            texts.setdefault(keywords[name], []).append(value)
    values = {}
    for keyword, row in known.items():
        if keyword in texts:
            values |= control_values(row, numbers.get(keyword), texts[keyword])
    group = getattr(scene.relievo, recipe.command)
    for keyword in group.bl_rna.properties.keys():
        group.property_unset(keyword)
    for keyword, value in values.items():
        setattr(group, keyword, value)
    scene.relievo.command = recipe.command


def control_values(row: Row, number: Slider | None, texts: list[str]) -> dict[str, Any]:
    """The properties of a setting for texts of a recipe."""
    last = texts[-1]
    if number is not None:
        is_word = last in row.words
        unset = {} if number.unset is None else {unset_of(row.keyword): is_word}
        return unset if is_word else {row.keyword: number_of(row, last), **unset}
    match row.kind:
        case "switch":
            return {row.keyword: last == "true"}
        case "choice" if last not in row.words:
            raise ValueError(f"{row.name} is {last} in the recipe; the sidebar takes one of {', '.join(row.words)}")
        case "text" if row.repeatable:
            return {row.keyword: f"{BETWEEN} ".join(texts)}
        case _:
            return {row.keyword: last}


def number_of(row: Row, value: str) -> float:
    """The number of a text."""
    try:
        return int(value) if row.whole else float(value)
    except ValueError:
        raise ValueError(f"{row.name} is {value} in the recipe; the sidebar takes one number") from None


def register() -> None:
    """Gives scenes their settings."""
    for group in (*GROUPS.values(), RelievoSettings):
        bpy.utils.register_class(group)
    bpy.types.Scene.relievo = PointerProperty(type=RelievoSettings)


def unregister() -> None:
    """Takes them away."""
    del bpy.types.Scene.relievo
    for group in (RelievoSettings, *GROUPS.values()):
        bpy.utils.unregister_class(group)
