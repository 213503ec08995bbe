"""Work on a thread of its own, in steps that leave Blender's window alive and can be cancelled between."""

import threading
import warnings
from collections.abc import Callable, Generator
from typing import Any


class Cancelled(Exception):
    """Ends work that nobody waits for any longer."""


class Job:
    """A call on a thread. It's given a function of a stage and a share, and must touch nothing of Blender's."""

    def __init__(self, call: Callable[[Callable[[str, float], None]], Any]):
        self.share = 0.0
        self._call = call
        self._is_cancelled = False
        self._result: Any = None
        self._said: list[str] = []
        self._error: BaseException | None = None

    def steps(self) -> Generator[float, None, Any]:
        """Runs it: gives the share that is done from time to time, returns the result and what it warned of."""
        thread = threading.Thread(target=self._run, name="relievo")
        thread.start()
        try:
            # At least one step, so that work of many short jobs can be cancelled too.
            yield self.share
            while thread.is_alive():
                yield self.share
        finally:
            self._is_cancelled = True
            thread.join()
        if self._error is not None:
            raise self._error
        return self._result, self._said

    def _run(self) -> None:
        try:
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always", UserWarning)
                self._result = self._call(self._progress)
            self._said = [str(one.message) for one in said if issubclass(one.category, UserWarning)]
        except BaseException as error:  # raised again where the result is waited for
            self._error = error

    def _progress(self, stage: str, share: float) -> None:
        self.share = share
        if self._is_cancelled:
            raise Cancelled
