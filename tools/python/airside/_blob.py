"""Weight blobs: what is in them, and who signed them."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _airside, _arguments


@dataclass(frozen=True)
class Signal:
    """An input of the network and how it is scaled: (value - mean) / scale."""

    name: str
    unit: str
    """"degc" or "kw"; "" of a 0/1 status."""
    mean: float
    scale: float


@dataclass(frozen=True)
class Layer:
    """A layer of the network."""

    name: str
    weights: npt.NDArray[np.float32]
    """Shape: outputs x inputs."""
    bias: npt.NDArray[np.float32]
    """Shape: outputs."""


@dataclass(frozen=True)
class Blob:
    """A weight blob. Format: docs/formats.md."""

    path: str
    bytes: int
    digest: str
    """CRC-32C of the whole file, as reports and logs name it."""
    digest_ok: bool
    """Whether the checksum in its header holds."""
    topology: str
    """Such as "5vav-5fcu-2power"; "" of a damaged blob of no known shape."""
    header: dict[str, str]
    """Header fields by name: format_version, site_scope, cycle_min, created, security_counter, key, ..."""
    provenance: str
    """The command that made it: twin, patches, weather, dates and, after a transfer, the parent and its digest."""
    signals: list[Signal]
    layers: list[Layer]
    head_gain_k_per_k: float | None
    """The room head's gain: K of the room a K of setpoint in one cycle. None without a head."""
    head_gain_sd_k_per_k: float | None
    facts: dict[str, Any]
    """All of `airside blob inspect --json`."""


@dataclass(frozen=True)
class Signature:
    """A signature that holds."""

    key_id: str
    key_name: str
    counter: int
    """A box takes a blob only with a higher counter than the last of this key."""


def _layer(span: tuple[str, int, int, int, int, int], weights: npt.NDArray[np.float32]) -> Layer:
    name, outputs, inputs, begin, bias, end = span
    return Layer(name, weights[begin:bias].reshape(outputs, inputs), weights[bias:end])


def read_blob(path: str | os.PathLike[str], *, damaged: bool = False) -> Blob:
    """Reads a blob whole and checks it, all but the signature (verify_blob).

    Raises InputError, naming file and field, where a controller would not take it. With `damaged` a blob that is cut short
    or altered is shown as far as it can be read: numbers that are missing are NaN, `facts["refusal"]` says what is wrong.
    """
    found = _airside.read_blob(_arguments.path("path", path), _arguments.flag("damaged", damaged))
    facts: dict[str, Any] = json.loads(found["json"])
    head = facts.get("head", {})
    nan = float("nan")
    return Blob(path=facts["file"], bytes=facts["bytes"], digest=facts["digest"], digest_ok=facts["digest_ok"],
                topology=facts["topology"], header=facts["header"], provenance=facts["provenance"],
                signals=[Signal(s["signal"], s["unit"], nan if s["mean"] is None else s["mean"],
                                nan if s["scale"] is None else s["scale"]) for s in facts["scaler"]],
                layers=[_layer(span, found["weights"]) for span in found["spans"]],
                head_gain_k_per_k=head.get("gain_k_per_k"), head_gain_sd_k_per_k=head.get("gain_sd_k_per_k"), facts=facts)


def verify_blob(path: str | os.PathLike[str], keys: str | os.PathLike[str]) -> Signature:
    """Checks the signature over every byte of a blob.

    `keys`: a public key file (`airside keygen` makes NAME.pub), or a folder of them with its list of revoked keys.
    Raises InputError for a blob that is unsigned, altered, or signed with another or a revoked key.
    """
    return Signature(*_airside.verify_blob(_arguments.path("path", path), _arguments.path("keys", keys)))
