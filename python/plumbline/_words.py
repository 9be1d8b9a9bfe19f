# SPDX-License-Identifier: Apache-2.0

"""Keyword arguments as the words of the command line, which says what they may be."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Union

from . import _core
from .errors import Notice

Progress = Union[bool, Callable[[str], object]]


def words(**options: Any) -> list[str]:
    """["--spp", "64"] of spp=64, and "--from" of from_=, which Python would not take. True stands for an option without a value; None and False are left
    out, as is what a render is not asked for."""
    said: list[str] = []
    for name, value in options.items():
        if value is None or value is False:
            continue
        said.append("--" + name.rstrip("_").replace("_", "-"))
        if value is not True:
            said.append(str(value))
    return said


def span(value: tuple[int, int | None] | str | None) -> str | None:
    """"2:5" of (2, 5), "2:" of (2, None)."""
    if value is None or isinstance(value, str):
        return value
    first, last = value
    return f"{first}:{'' if last is None else last}"


def joined(value: Any, separator: str) -> str | None:
    """"640x480" of (640, 480)."""
    return value if value is None or isinstance(value, str) else separator.join(map(str, value))


def warn_of_notices(stacklevel: int = 3) -> None:
    """Passes on what the libraries have to say."""
    for notice in _core.take_notices():
        warnings.warn(notice, Notice, stacklevel=stacklevel)


@contextmanager
def shown(progress: Progress) -> Iterator[Callable[[str], object] | None]:
    """What gets the lines that tell how far long work is: True is for a line on standard error."""
    if not isinstance(progress, bool):
        yield progress
    elif not progress:
        yield None
    else:
        width = 0

        def show(line: str) -> None:
            nonlocal width
            width = max(width, len(line))
            print("\r" + line.ljust(width), end="", file=sys.stderr, flush=True)
        try:
            yield show
        finally:
            print("\r" + " " * width + "\r", end="", file=sys.stderr, flush=True)
