"""A log in columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from . import _flotilla

if TYPE_CHECKING:
    import pandas

__all__ = ["Log", "read_log"]


class Log(Mapping[str, dict[str, NDArray[Any]]]):
    """Topics by name, each a dictionary of columns: the tables of `flotilla export`, with the same names.

    Times are seconds, and a column's name ends with its unit. Where a name comes twice the second is `NAME.1`, as in pandas. A whole number or truth value that may be missing is floating, and not a
    number where it is missing.
    """

    #: Whether the file ends as a log does; it is cut otherwise.
    whole: bool

    def __init__(self, topics: dict[str, dict[str, NDArray[Any]]], whole: bool) -> None:
        self._topics = topics
        self.whole = whole

    def __getitem__(self, topic: str) -> dict[str, NDArray[Any]]:
        return self._topics[topic]

    def __iter__(self) -> Iterator[str]:
        return iter(self._topics)

    def __len__(self) -> int:
        return len(self._topics)

    def __repr__(self) -> str:
        return f"Log({', '.join(self._topics)})"

    def frame(self, topic: str) -> pandas.DataFrame:
        """A topic as a table of pandas, which must be installed."""
        import pandas

        return pandas.DataFrame(self._topics[topic])


def read_log(path: str | PathLike[str], topics: Iterable[str] | None = None) -> Log:
    """Reads a log of a run; these topics alone, or all."""
    chosen = None if topics is None else list(topics)
    return Log(*_flotilla.read_log(path, chosen))
