"""Docstrings, their examples, the README, and types."""

import doctest
import importlib
import inspect
import pathlib
import pkgutil
import re
import subprocess
import sys

import pytest

import sphvar

PYTHON = pathlib.Path(__file__).parents[1]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def modules():
    """Return the modules of the package that are written in Python, and those of the native one."""
    names = [info.name for info in pkgutil.iter_modules(sphvar.__path__)]
    return [sphvar, *(importlib.import_module(f"sphvar.{name}") for name in names)]


def examples():
    """Return the docstrings with examples of the package."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = {}
    for module in modules():
        for test in finder.find(module, module.__name__):
            if test.examples:
                found[test.name] = test
    # Native functions are not of a module that is written in Python.
    for name, function in public():
        has_examples = ">>> " in (function.__doc__ or "")
        if has_examples and not any(key.endswith(f".{name}") for key in found):
            parser = doctest.DocTestParser()
            found[name] = parser.get_doctest(function.__doc__, {}, name, None, None)
    return found


def public():
    """Return the public functions, classes and their public members, with names."""
    found = []
    for name in sphvar.__all__:
        item = getattr(sphvar, name)
        if inspect.ismodule(item):
            found += [(f"{name}.{key}", getattr(item, key)) for key in item.__all__]
        elif callable(item) and getattr(item, "__module__", "").startswith("sphvar"):
            found.append((name, item))
    for name, item in list(found):
        if inspect.isclass(item):
            found += [
                (f"{name}.{key}", member)
                for base in item.__mro__
                if base.__module__.startswith("sphvar")
                for key, member in vars(base).items()
                if not key.startswith("_") and (callable(member) or isinstance(member, property))
            ]
    return found


EXAMPLES = examples()
PUBLIC = dict(public())


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_run(name):
    output = []
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    runner.run(EXAMPLES[name], out=output.append)
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")
    assert runner.summarize(verbose=False).failed == 0, "".join(output)


def section(text, title):
    """Return a section of a numpy-style docstring, empty if there is none."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=\n\n\S[^\n]*\n-+\n|\Z)", text, re.S | re.M)
    return found[1] if found else ""


@pytest.mark.parametrize("name", PUBLIC)
def test_docstrings_describe_everything(name):
    item = PUBLIC[name]
    text = inspect.getdoc(item)
    assert text, "no docstring"
    first = text.splitlines()[0]
    assert first.endswith((".", "?")), "the first line is no sentence"
    if inspect.isclass(item) and issubclass(item, (sphvar.Result, Warning)):
        # Results are not made by users; the functions that return them have examples.
        return
    try:
        parameters = [p for p in inspect.signature(item).parameters if p != "self"]
    except (TypeError, ValueError):
        parameters = []
    # The examples of a class show its properties and methods without parameters.
    if parameters or inspect.isclass(item) or inspect.isroutine(item) and "." not in name:
        assert ">>> " in section(text, "Examples"), "no example"
    if isinstance(item, property):
        return
    described = section(text, "Parameters")
    names = {
        word.strip("* ")
        for line in re.findall(r"^(\S[^:\n]*)", described, re.M)
        for word in line.split(",")
    }
    missing = [p for p in parameters if p not in names]
    assert not missing, f"undescribed parameters: {missing}"
    if not inspect.isclass(item):
        returns = section(text, "Returns") or section(text, "Yields")
        annotation = getattr(item, "__annotations__", {}).get("return")
        assert returns or annotation in (None, "None", "dict[str, Any]", "Any"), "no Returns"


def test_public_names_are_sorted_and_exist():
    assert sphvar.__all__ == sorted(sphvar.__all__)
    assert len(set(sphvar.__all__)) == len(sphvar.__all__)
    assert set(sphvar.__all__) <= set(dir(sphvar))


def test_the_readme_runs(capsys):
    pytest.importorskip("matplotlib")
    readme = (PYTHON / "README.md").read_text(encoding="utf-8")
    code = re.findall(r"^```python\n(.*?)^```", readme, re.S | re.M)
    assert len(code) == 1
    assert len(code[0].splitlines()) <= 10
    exec(compile(code[0], "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "fibonacci" in printed
    assert "mine" in printed
    assert "value" in printed
    table = readme.split("```")[-1]
    named = set(re.findall(r"`(\w+)", table))
    functions = {name for name, item in PUBLIC.items() if "." not in name and not _is_result(item)}
    assert functions - named == set(), "the table lacks functions"


def _is_result(item):
    return inspect.isclass(item) and issubclass(item, (sphvar.Result, Warning))


def python(*words):
    """Run a module in python/, where the package of the source tree is found first."""
    run = subprocess.run(
        [sys.executable, "-m", *words], cwd=PYTHON, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr


def test_typical_uses_are_typed():
    pytest.importorskip("mypy")
    python("mypy", "--strict", "tests/typing_cases.py")
