"""Trained weights on disk: `NAME.safetensors` with the tensors, `NAME.json` with a header. No pickle is read."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save
from torch import Tensor, nn

from kinmo._core import __version__
from kinmo.core.errors import InputError
from kinmo.io.atomic_files import write_bytes_atomically, write_json_atomically
from kinmo.learning.model_folder import OTHER_VERSION, saved_config

T = TypeVar("T")

SCHEMA = 1
"""Version of the header's format."""
DEVICES = ("cpu", "cuda", "mps")
"""Kinds of device that kinmo computes on."""
ACCELERATOR_PROCESSES = 4
"""Number of processes that may share an accelerator; each has its own copy of the networks there."""


@dataclass(frozen=True, eq=False)
class Weights:
    """Trained weights in memory.

    Attributes:
        path: File that the tensors were read from.
        tensors: Tensors by parameter name, on the CPU.
        config: Configuration of the network, as plain data.
        facts: Facts about the training, such as the seed and the number of shapes, as plain data.
        sha256: SHA-256 of the file.
    """

    path: Path
    tensors: Mapping[str, Tensor]
    config: Mapping[str, Any]
    facts: Mapping[str, Any]
    sha256: str

    def typed_config(self, kind: type[T]) -> T:
        """The configuration as a dataclass.

        Raises:
            InputError: The configuration is not one of this version of kinmo.
        """
        return saved_config(kind, self.config, self.path.with_suffix(".json"), "config.")

    def sizes(self, *names: str) -> tuple[int, ...]:
        """Facts that are numbers of features, by name.

        Raises:
            InputError: One of them is missing or no whole number.
        """
        found = tuple(value for name in names if isinstance(value := self.facts.get(name), int))
        if len(found) < len(names):
            problem = f"expected whole numbers {' and '.join(names)}{OTHER_VERSION}"
            raise InputError(self.path.with_suffix(".json"), problem, "facts")
        return found

    def fill(self, module: nn.Module) -> None:
        """Copy the tensors into a module.

        Raises:
            InputError: A name or a shape differs from the module's; the message names the tensor.
        """
        own = module.state_dict()
        for name in sorted(own.keys() | self.tensors.keys()):
            if name not in self.tensors:
                raise InputError(self.path, f"missing tensor{OTHER_VERSION}", name)
            if name not in own:
                raise InputError(self.path, f"unexpected tensor{OTHER_VERSION}", name)
            if own[name].shape != self.tensors[name].shape:
                found, expected = tuple(self.tensors[name].shape), tuple(own[name].shape)
                raise InputError(self.path, f"shape {found}, expected {expected}{OTHER_VERSION}", name)
        module.load_state_dict(dict(self.tensors))


def save_weights(
    path: Path, module: nn.Module, kind: str, config: Mapping[str, Any], facts: Mapping[str, Any] | None = None
) -> str:
    """Write the weights of a module to `NAME.safetensors` and their header to `NAME.json`, each file atomically.

    The header has the kind of network, such as "motion_gnn", its configuration, and facts about the training, as plain data.

    Returns:
        SHA-256 of the weights file.
    """
    tensors = {name: tensor.detach().cpu().contiguous() for name, tensor in module.state_dict().items()}
    data = save(tensors)
    write_bytes_atomically(path, data)
    digest = hashlib.sha256(data).hexdigest()
    header = {"schema": SCHEMA, "kinmo": __version__, "kind": kind, "sha256": digest, "config": config, "facts": facts or {}}
    write_json_atomically(path.with_suffix(".json"), header, sort_keys=True)
    return digest


def load_weights(path: Path, kind: str) -> Weights:
    """Read the weights and the header that `save_weights` wrote for a kind of network.

    Raises:
        InputError: A file is absent or cut, the two do not belong together, or they are for another kind of network.
    """
    header_path = path.with_suffix(".json")
    try:
        header = json.loads(header_path.read_text(encoding="utf-8"))
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(Path(error.filename), f"expected trained weights ({error.strerror})") from error
    except ValueError as error:
        raise InputError(header_path, f"expected JSON ({error})") from error
    if not isinstance(header, dict) or not isinstance(header.get("config"), dict):
        raise InputError(header_path, "expected an object", "config")
    if header.get("schema") != SCHEMA:
        raise InputError(header_path, f"expected {SCHEMA}, got {header.get('schema')!r}", "schema")
    if header.get("kind") != kind:
        raise InputError(header_path, f"expected {kind!r}, got {header.get('kind')!r}", "kind")
    if header.get("sha256") != digest:
        raise InputError(path, f"does not belong to {header_path.name}", "sha256")
    try:
        tensors = load_file(path)
    except (SafetensorError, ValueError) as error:
        raise InputError(path, f"expected a safetensors file ({error})") from error
    return Weights(path, tensors, header["config"], header.get("facts") or {}, digest)


def pick_device(name: str) -> str:
    """Name of a device that exists: "cpu" (also for "cpu:N"), "cuda", "cuda:1", "mps", or the GPU or CPU that "auto" means.

    Raises:
        InputError: There is no such device, or kinmo cannot compute on it.
    """
    if name == "auto":
        return "cuda" if torch.cuda.is_available() else "mps" if torch.backends.mps.is_available() else "cpu"
    try:
        kind = torch.empty(0, device=name).device.type
    except (RuntimeError, AssertionError) as error:
        reason = str(error).splitlines()[0].split(". ")[0]
        raise InputError("--device", f"{name!r} is not available here ({reason})") from error
    if kind not in DEVICES:
        raise InputError("--device", f"{name!r} is not available here (expected one of {', '.join(DEVICES)})")
    return "cpu" if kind == "cpu" else name


def processes_on(device: str, workers: int) -> int:
    """Number of worker processes that may use networks on a device at once; on an accelerator they share its memory."""
    return workers if pick_device(device) == "cpu" else min(workers, ACCELERATOR_PROCESSES)
