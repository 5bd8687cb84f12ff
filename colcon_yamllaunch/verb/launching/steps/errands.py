# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is done for several machines at once, each by a thread of its own."""

from collections.abc import Callable
from collections.abc import Mapping
import threading
from typing import Generic
from typing import TypeVar

from colcon_yamllaunch.common.errors import UserError

_Result = TypeVar('_Result')


class Errands(Generic[_Result]):
    """
    Something that is done for each of some machines.

    :param what: Does it, by the name of the machine; begun at once
    """

    def __init__(self, what: Mapping[str, Callable[[], _Result]]) -> None:
        self._results: dict[str, _Result] = {}
        self._errors: dict[str, Exception] = {}
        self._threads = {
            name: threading.Thread(
                target=self._run, args=(name, do), name=name, daemon=True
            )
            for name, do in what.items()
        }
        for thread in self._threads.values():
            thread.start()

    def wait(self, seconds: float | None = None) -> bool:
        """
        Wait until all is done; a signal may end that.

        Return whether it is.

        :param seconds: How long for each at most, None for ever
        """
        for thread in self._threads.values():
            thread.join(seconds)
        return not any(t.is_alive() for t in self._threads.values())

    @property
    def results(self) -> Mapping[str, _Result]:
        """What came of it where it succeeded."""
        return self._results

    @property
    def errors(self) -> Mapping[str, Exception]:
        """What went wrong where it did not."""
        return self._errors

    def check(self) -> None:
        """
        Tell all that went wrong, if anything did.

        :raises UserError: when it did
        """
        for error in self._errors.values():
            if not isinstance(error, UserError):
                raise error
        # each machine's own, in the order of the machines
        found = [self._errors[n] for n in self._threads if n in self._errors]
        if found:
            raise UserError('\n'.join(dict.fromkeys(map(str, found))))

    def forgive(self, name: str) -> None:
        """Take into account that what went wrong was put right."""
        del self._errors[name]

    def _run(self, name: str, do: Callable[[], _Result]) -> None:
        try:
            self._results[name] = do()
        except Exception as e:  # noqa: BLE001
            # told in the main thread
            self._errors[name] = e
