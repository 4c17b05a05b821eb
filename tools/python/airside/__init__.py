"""airside for Python: simulated rooms, logs, weights and the gap workflow.

Everything is computed by the code of the program `airside`, linked into this package: the same seed gives the same bits.
docs/python.md of the project has an example.
"""

from __future__ import annotations

from importlib.metadata import version as _version

from ._airside import program_text as _program_text
from ._blob import Blob, Layer, Signal, Signature, read_blob, verify_blob
from ._errors import InputError
from ._gap import GapVerdict, gap
from ._log import Log, read_log
from ._simulate import Figures, Run, simulate

__version__ = _version("airside")


def program_text() -> str:
    """Version and commit of the code in this package, as `airside --version` prints them."""
    return _program_text()


__all__ = ["Blob", "Figures", "GapVerdict", "InputError", "Layer", "Log", "Run", "Signal", "Signature", "gap",
           "program_text", "read_blob", "read_log", "simulate", "verify_blob"]
