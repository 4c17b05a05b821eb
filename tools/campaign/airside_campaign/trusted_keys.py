"""Keys that sign the index of a weight library: files of `airside keygen`, and a folder of public ones as a box has."""

import hashlib
import os
import stat
from dataclasses import dataclass
from pathlib import Path

from nacl.exceptions import BadSignatureError
from nacl.signing import SigningKey, VerifyKey

from airside_campaign.complaint import BadInput

DOMAIN = b"airside weight library 1\0"  # a signature of anything else is none of an index


@dataclass(frozen=True)
class PublicKey:
    key: VerifyKey
    name: str
    id: str  # 16 hex digits, as in a blob's header


def _words(path, word, digits):
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise BadInput(
            path, error.strerror.lower(), "a key file that `airside keygen` wrote", "check the path and its rights"
        ) from error
    parts = text.strip().split(maxsplit=2)
    if len(parts) < 2 or parts[0] != word or len(parts[1]) != digits or set(parts[1]) - set("0123456789abcdef"):
        raise BadInput(
            path,
            "something else",
            f"one line `{word} HEX NAME` of {digits} hex digits",
            "give the .key file to whoever signs and the .pub file to whoever reads",
        )
    return parts[1], parts[2] if len(parts) == 3 else ""


def id_of(public_bytes):
    return hashlib.blake2b(public_bytes, digest_size=16).digest()[:8].hex()


def read_secret(path):
    """Of a NAME.key that nobody else may read."""
    digits, name = _words(path, "airside-secret-key-1", 128)
    if stat.S_IMODE(os.stat(path).st_mode) & 0o077:
        raise BadInput(path, "rights for others", "mode 600", f"chmod 600 {path}")
    return SigningKey(bytes.fromhex(digits)[:32]), name


def read_trusted(path):
    """Keys by their id: of one NAME.pub, or of all in a folder but those that its file `revoked` names."""
    path = Path(path)
    files = sorted(path.glob("*.pub")) if path.is_dir() else [path]
    if not files:
        raise BadInput(path, "no *.pub", "public keys of those whose library is believed", "copy them there")
    keys = {}
    for file in files:
        digits, name = _words(file, "airside-public-key-1", 64)
        raw = bytes.fromhex(digits)
        keys[id_of(raw)] = PublicKey(VerifyKey(raw), name, id_of(raw))
    revoked = path / "revoked"
    if path.is_dir() and revoked.is_file():
        for line in revoked.read_text(encoding="utf-8").splitlines():
            keys.pop(line.split("#")[0].strip().lower(), None)
    return keys


def sign(secret, text):
    return secret.sign(DOMAIN + text.encode()).signature.hex()


def is_signed(key, text, signature):
    try:
        key.verify(DOMAIN + text.encode(), bytes.fromhex(signature))
    except (BadSignatureError, ValueError):
        return False
    return True
