__all__ = [
    "Engine",
    "Frame",
    "Made",
    "commands",
    "forked",
    "frames_on_disk",
    "png",
    "read_recipe",
    "recipe",
    "recipe_settings",
    "run_command_line",
    "settings",
]

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

_Settings: TypeAlias = Sequence[tuple[str, str]]
_Progress: TypeAlias = Callable[[str, float], Any] | None

@final
class Frame:
    @staticmethod
    def of_arrays(
        arrays: dict[str, NDArray[Any]],
        roles: _Settings,
        camera: str | None = None,
        pixel_aspect: float = 1.0,
        height_scale: float | None = None,
    ) -> Frame: ...
    @staticmethod
    def of_file(path: str, roles: _Settings, number: int | None = None) -> Frame: ...
    def layer(self, name: str) -> Any: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def findings(self) -> list[tuple[str, str, str, str]]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def camera(self) -> str | None: ...
    @property
    def path(self) -> Any: ...

@final
class Made:
    def picture(self, out: Any = None) -> Any: ...
    def shown(self) -> Any: ...
    def layers(self) -> tuple[list[tuple[str, float | None, int]], NDArray[np.float32]]: ...
    @property
    def map_names(self) -> list[str]: ...
    @property
    def svg(self) -> str | None: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def choices(self) -> list[tuple[str, str]]: ...
    @property
    def recipe(self) -> str: ...

@final
class Engine:
    def __new__(cls, *, threads: int | None = None, backend: str = "auto") -> Engine: ...
    def run(
        self, command: str, settings: _Settings, frame: Frame, form: str = "planes", progress: _Progress = None
    ) -> Made: ...
    def run_recipe(
        self,
        path: str,
        text: str | None,
        settings: _Settings,
        frame: Frame,
        form: str = "planes",
        progress: _Progress = None,
    ) -> Made: ...
    def choose(
        self,
        command: str,
        settings: _Settings,
        pattern: str,
        frames: Sequence[int],
        progress: _Progress = None,
    ) -> list[tuple[str, str]]: ...

def settings(command: str) -> list[dict[str, Any]]: ...
def commands() -> list[str]: ...
def forked() -> None: ...
def frames_on_disk(pattern: str) -> list[int] | None: ...
def run_command_line(words: Sequence[str]) -> int: ...
def recipe(command: str, settings: _Settings) -> str: ...
def read_recipe(path: str, text: str | None) -> tuple[str, str]: ...
def recipe_settings(path: str, text: str) -> list[tuple[str, str]]: ...
def png(array: NDArray[np.float32], is_linear: bool) -> bytes: ...
