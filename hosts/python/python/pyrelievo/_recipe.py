"""Recipes: a command with its settings, shared with the command line."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from . import _relievo
from ._commands import default_engine, finished, frame_of
from ._frame import Floats, Path
from ._settings import typed


class Recipe:
    """A command with its settings, as ``relievo --save-recipe`` writes and ``relievo run`` reads them.

    ``Recipe("enhance", scaling=1.5)`` makes one, ``Recipe.read("look.toml")`` reads a file or a preset, as ``portrait``,
    and ``Recipe.parse(text)`` a text. A recipe is called with what its command takes: ``recipe(frame)``.
    """

    def __init__(self, command: str, **settings: Any):
        self._path = "recipe"
        self._text = _relievo.recipe(command, typed(command, settings))
        self.command = command

    @classmethod
    def read(cls, path: Path) -> Recipe:
        """The recipe of a file, or a preset."""
        return cls._of(os.fspath(path), None)

    @classmethod
    def parse(cls, text: str) -> Recipe:
        """The recipe of a text in TOML."""
        return cls._of("recipe", text)

    @classmethod
    def _of(cls, path: str, text: str | None) -> Recipe:
        recipe = cls.__new__(cls)
        recipe._path = path
        recipe.command, recipe._text = _relievo.read_recipe(path, text)
        return recipe

    @property
    def settings(self) -> list[tuple[str, str]]:
        """Its settings, by their names on the command line."""
        return _relievo.recipe_settings(self._path, self._text)

    def toml(self) -> str:
        """The text of the recipe."""
        return self._text

    def write(self, path: Path) -> None:
        """Writes it to a file."""
        with open(os.fspath(path), "w", encoding="utf-8") as file:
            file.write(self._text)

    def __call__(
        self,
        *arrays: Any,
        out: Floats | None = None,
        dtype: Any = None,
        engine: _relievo.Engine | None = None,
        progress: Callable[[str, float], Any] | None = None,
        **settings: Any,
    ) -> Any:
        """What the recipe's command makes of a frame or of arrays; settings overrule those of the recipe."""
        frame, settings = frame_of(self.command, arrays, settings)
        given = typed(self.command, settings)

        def make(form: str = "planes") -> _relievo.Made:
            return (engine or default_engine()).run_recipe(self._path, self._text, given, frame._frame, form, progress)

        return finished(self.command, make, out, dtype)

    def __repr__(self) -> str:
        return f"<pyrelievo.Recipe for {self.command}>"
