"""The names of `kinmo`: they are listed, documented, and loaded only when they are used."""

from __future__ import annotations

import inspect
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import is_dataclass
from enum import Enum

import pytest

import kinmo

NAMES = [name for name in kinmo.__all__ if name != "__version__"]
PRODUCT = (
    "Predictor",
    "Prediction",
    "PredictedJoint",
    "ScanPredictor",
    "ScanPrediction",
    "load",
    "prepare",
    "train",
    "evaluate",
)


def functions() -> Iterator[tuple[str, Callable[..., object]]]:
    """Public functions and methods of the API, with their names."""
    for name in PRODUCT:
        value = getattr(kinmo, name)
        if not inspect.isclass(value):
            yield name, value
            continue
        for own, member in vars(value).items():
            member = member.__func__ if isinstance(member, classmethod) else member
            if inspect.isfunction(member) and not own.startswith("_"):
                yield f"{name}.{own}", member


FUNCTIONS = dict(functions())


def test_import_loads_neither_torch_nor_scipy() -> None:
    code = "import sys, kinmo; dir(kinmo); print(*{'torch', 'scipy', 'numpy', 'trimesh'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == ""


def test_reading_and_preparing_load_no_torch() -> None:
    code = "import sys, kinmo; kinmo.load, kinmo.prepare, kinmo.Prediction, kinmo.Shape; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "False"


def test_dir_lists_the_public_names() -> None:
    assert dir(kinmo) == sorted(kinmo.__all__)
    assert all(getattr(kinmo, name) is not None for name in kinmo.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'kinmo' has no attribute 'predict'"):
        kinmo.predict  # noqa: B018


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_a_docstring(name: str) -> None:
    assert len(inspect.getdoc(getattr(kinmo, name)) or "") > 20


@pytest.mark.parametrize("name", [name for name in NAMES if is_dataclass(getattr(kinmo, name))])
def test_every_field_of_a_public_class_is_described(name: str) -> None:
    value = getattr(kinmo, name)
    text = inspect.getdoc(value) or ""
    for own in vars(value)["__annotations__"]:
        assert own.startswith("_") or f"{own}:" in text or issubclass(value, Enum), f"{name}.{own}"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_public_function_describes_arguments_and_results(name: str) -> None:
    function, text = FUNCTIONS[name], inspect.getdoc(FUNCTIONS[name]) or ""
    signature = inspect.signature(function)
    arguments = [own for own in signature.parameters if own not in ("self", "cls")]
    assert not arguments or "Args:" in text
    for own in arguments:
        assert f"{own}:" in text, f"{name}: {own}"
    assert signature.return_annotation in (None, "None") or "Returns:" in text


def test_the_arguments_of_predictors_are_described() -> None:
    for value in (kinmo.Predictor,):
        text = inspect.getdoc(value) or ""
        for own in inspect.signature(value).parameters:
            assert f"{own}:" in text
