# SPDX-License-Identifier: Apache-2.0
"""Long calls of the library in a thread of their own, so that Ctrl-C reaches whoever waits."""

from __future__ import annotations

import atexit
import queue
import threading
import weakref
from typing import Any, Callable, Optional

_jobs: "weakref.WeakSet[Job]" = weakref.WeakSet()

_TOLD, _DONE, _FAILED = range(3)


class Job:
    """
    Work that a thread does for the one that waits for it.

    `work(job)` runs in the new thread; what it gives to tell() reaches `told` in the thread that
    waits, with no lock held. ask() runs a function in the new thread while that thread waits in
    tell(): only there may it use what belongs to a callback of the library.
    """

    def __init__(self, work: Callable[["Job"], Any]) -> None:
        self.stopped = False
        self._work = work
        self._events: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        self._answers: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        self._asked: "queue.SimpleQueue[Any]" = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="mcvisi", daemon=True)
        _jobs.add(self)

    def _run(self) -> None:
        try:
            self._events.put((_DONE, self._work(self)))
        except BaseException as error:  # it is raised where somebody waits
            self._events.put((_FAILED, error))

    # In the new thread.

    def tell(self, item: Any) -> None:
        """Hands an item over, without waiting."""
        self._events.put((_TOLD, item))

    def tell_and_wait(self, item: Any) -> None:
        """Hands an item over, and does what is asked until it has been seen."""
        self._events.put((_TOLD, item))
        while not self.stopped:
            question = self._asked.get()
            if question is None:
                return
            try:
                self._answers.put((question(), None))
            except BaseException as error:
                self._answers.put((None, error))

    # In the thread that waits.

    def start(self) -> None:
        self._thread.start()

    def ask(self, question: Callable[[], Any]) -> Any:
        self._asked.put(question)
        answer, error = self._answers.get()
        if error is not None:
            raise error
        return answer

    def seen(self) -> None:
        """Lets tell_and_wait go on."""
        self._asked.put(None)

    def stop(self) -> None:
        """The work ends at the library's next callback."""
        self.stopped = True
        self._asked.put(None)

    def next(self) -> "tuple[bool, Any]":
        """(True, what was told), or (False, what the work returned); raises what the work did."""
        kind, item = self._events.get()
        if kind == _FAILED:
            raise item
        return kind == _TOLD, item

    def wait(self, told: Optional[Callable[[Any], None]] = None) -> Any:
        """What the work returns; hands what is told to `told`."""
        while True:
            more, item = self.next()
            if not more:
                return item
            if told is not None and not self.stopped:
                told(item)


@atexit.register
def _stop_all() -> None:
    """Nothing may call back into an interpreter that has ended."""
    for job in list(_jobs):
        if job._thread.is_alive():
            job.stop()
            job._thread.join(10)
