"""A call as a question to the command: keywords become its words, and its document comes back."""

from __future__ import annotations

import difflib
import functools
import inspect
import json
import operator
import os
import re
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, ParamSpec, Protocol, TypeVar

import numpy as np

from ._checks import seed_of

_P = ParamSpec("_P")
_R = TypeVar("_R")

_PACKAGE = os.path.dirname(os.path.abspath(__file__))

# The keywords of options that the command names otherwise.
_NAMES = {"n": "count", "source": "points"}

# The letters by which messages of the command name options, by keyword.
_LETTERS = {"n": "n", "realizations": "m", "seed": "s"}


class SphvarWarning(UserWarning):
    """A warning of the command, for example on a file whose content does not match its name."""


class AnsweringSession(Protocol):
    """What answers questions: the native session, or another with the same methods."""

    def answer(self, words: list[str]) -> str:
        """Return the JSON document that the command prints for ``words``."""

    def remarks(self) -> list[str]:
        """Return the messages of all answers."""


def flag(keyword: str) -> str:
    """Return the option of the command that a keyword stands for."""
    return "--" + _NAMES.get(keyword, keyword).replace("_", "-")


class Keywords:
    """The options of a function, which messages of the command name as its command line has them.

    Parameters
    ----------
    function
        A function of the package.
    """

    # What clap writes for one of several options, for one option, and what the messages of the command do.
    # Options with a number come with it. Quoted texts, such as what the user gave, stay as they are.
    _MENTION = re.compile(
        r"""(?P<text>"[^"]*")"""
        r"""|<(?P<either>--[\w-]+(?:\ <\w+>)?(?:\|--[\w-]+(?:\ <\w+>)?)+)>"""
        r"""|'(?P<quoted>--[\w-]+)(?:\ <\w+>(?:\.\.\.)?)?'"""
        r"""|(?<![\w'./=-])(?:-\w/)?(?P<plain>--[a-z][\w-]*|-[a-z])(?![\w-])"""
        r"""(?:[\ =](?P<value>\d[\w.+-]*\b%?)|(?P<is_subject>,|/|\ (?:must|is|are|has|needs|does|cannot|requires)\b))?"""
    )

    def __init__(self, function: Callable[..., Any]) -> None:
        self._texts: dict[str, tuple[str, str]] = {}
        for keyword, parameter in inspect.signature(function).parameters.items():
            default = parameter.default
            if default is True:
                self._texts[flag(f"no_{keyword}")] = keyword, f"{keyword}=False"
            else:
                text = f"{keyword}=True" if default is False else f"{keyword}="
                self._texts[flag(keyword)] = keyword, text
                if keyword in _LETTERS:
                    self._texts["-" + _LETTERS[keyword]] = keyword, text

    def translate(self, message: str) -> str:
        """Return a message of the command with keywords for the options that the function has."""
        return self._MENTION.sub(self._mention, message) if "-" in message else message

    def _mention(self, found: re.Match[str]) -> str:
        either, name = found["either"], found["quoted"] or found["plain"]
        if either is not None:
            names = [option.split(" ")[0] for option in either.split("|")]
            return " or ".join(self._texts.get(name, (name,))[0] for name in names)
        if name not in self._texts:
            return found[0]
        keyword, text = self._texts[name]
        if found["value"] is not None:
            return f"{keyword}={found['value']}"
        is_name = found["quoted"] is not None or found["is_subject"] is not None
        is_name = is_name and not text.endswith(("True", "False"))
        return (keyword if is_name or found["quoted"] else text) + (found["is_subject"] or "")


class _Speaker(threading.local):
    """The function of the package that a thread is in."""

    keywords: Keywords | None = None


_speaker = _Speaker()


def in_keywords(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Let the exceptions and warnings of a function name options as its keywords.

    Exceptions that a callable of the user raises stay as they are.
    """
    keywords = Keywords(function)

    @functools.wraps(function)
    def call(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        before, _speaker.keywords = _speaker.keywords, keywords
        try:
            return function(*args, **kwargs)
        except (ValueError, OSError, MemoryError, RuntimeError) as error:
            if len(error.args) == 1 and isinstance(error.args[0], str) and _is_own(error):
                error.args = (keywords.translate(error.args[0]),)
            raise
        finally:
            _speaker.keywords = before

    return call


def _is_own(error: Exception) -> bool:
    """Return whether the package raised an exception, not a callable of the user."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and os.path.dirname(trace.tb_frame.f_code.co_filename) == _PACKAGE


def checked(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Let a function name the close ones for a keyword that it does not have.

    Its messages name options as keywords, too: `in_keywords`.

    Parameters
    ----------
    function
        A function without ``**kwargs``.

    Returns
    -------
    callable
        The same function; unknown keywords are a ``TypeError`` before anything runs.
    """
    known = list(inspect.signature(function).parameters)
    names = frozenset(known)
    spoken = in_keywords(function)

    @functools.wraps(function)
    def call(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        if not names.issuperset(kwargs):
            unknown = next(name for name in kwargs if name not in names)
            raise TypeError(_unknown_keyword(function.__name__, unknown, known))
        return spoken(*args, **kwargs)

    return call


def _unknown_keyword(function: str, unknown: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(unknown, known, n=3)
    close += [name for name in known if name not in close and name in unknown.split("_")]
    advice = f"did you mean {' or '.join(close)}?" if close else f"there are {', '.join(known)}"
    return f"{function}() has no keyword {unknown!r}: {advice}"


def words(command: str, positional: Iterable[str], options: Mapping[str, Any]) -> list[str]:
    """Return the words of the command line for a question.

    Parameters
    ----------
    command
        The subcommand.
    positional
        Its arguments.
    options
        Values by keyword: ``True`` is a flag, ``None`` and ``False`` omit the option, lists and
        ranges are joined by commas, and numbers keep all their digits.

    Returns
    -------
    list of str
        The words after the name of the command.
    """
    arguments = [command]
    for text in positional:
        if text.startswith("-"):
            raise ValueError(f"expected a name, got {text!r}")
        arguments.append(text)
    for keyword, value in options.items():
        name = flag(keyword)
        if keyword == "seed" and value is not None:
            value = seed_of(value)
        if value is None or value is False or value is np.False_:
            continue
        if value is True or value is np.True_:
            arguments.append(name)
        else:
            arguments.append(f"{name}={_text(keyword, value)}")
    return arguments


def _text(keyword: str, value: Any) -> str:
    """Return a value as the command reads it."""
    if isinstance(value, str):
        return value
    if not isinstance(value, (bool, np.bool_)):
        try:
            return str(operator.index(value))
        except TypeError:
            pass
        if isinstance(value, (float, np.floating)):
            return _decimal(float(value))
        if isinstance(value, np.ndarray) and value.ndim == 1:
            return ",".join(_text(keyword, item) for item in value.tolist())
        if isinstance(value, (Sequence, frozenset, set)) and not isinstance(value, (bytes, bytearray)):
            return ",".join(_text(keyword, item) for item in value)
    raise TypeError(
        f"{keyword}: expected a number, a text or a list of them, got {type(value).__name__}"
    )


def _decimal(value: float) -> str:
    """Return a number with all its digits; a whole one without a fraction, for counts."""
    if value.is_integer() and abs(value) < 2.0**53:
        return str(int(value)) if value or str(value)[0] != "-" else "-0.0"
    return repr(value)


def ask(
    command: str,
    positional: Iterable[str],
    options: Mapping[str, Any],
    session: AnsweringSession,
) -> dict[str, Any]:
    """Return the document of the command for a question.

    Parameters
    ----------
    command
        The subcommand.
    positional
        Its arguments.
    options
        Values by keyword, as in :func:`words`.
    session
        What answers it.

    Returns
    -------
    dict
        The document of ``--json``, with bit-identical numbers.

    Raises
    ------
    ValueError, OSError, MemoryError, RuntimeError
        In the words of the command.

    Warns
    -----
    SphvarWarning
        For warnings of the command.
    """
    return document(answer(command, positional, options, session))


def answer(
    command: str,
    positional: Iterable[str],
    options: Mapping[str, Any],
    session: AnsweringSession,
) -> str:
    """Return the document of :func:`ask` as JSON."""
    text = session.answer(words(command, positional, options))
    warn_of(session)
    return text


def document(answer: str) -> dict[str, Any]:
    """Return a JSON document as a dictionary; the digits of numbers have all their bits."""
    parsed: dict[str, Any] = json.loads(answer)
    return parsed


def warn_of(session: AnsweringSession) -> None:
    """Warn at the line of the caller of the package what a session warned of."""
    for remark in session.remarks():
        if remark.startswith("warning: "):
            warn(remark.removeprefix("warning: "))


def warn(message: str) -> None:
    """Warn at the line of the caller of the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == _PACKAGE:
        frame, level = frame.f_back, level + 1
    if _speaker.keywords is not None:
        message = _speaker.keywords.translate(message)
    warnings.warn(message, SphvarWarning, stacklevel=level)
