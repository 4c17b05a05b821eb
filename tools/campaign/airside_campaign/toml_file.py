"""Files that people write in TOML."""

import tomllib

from airside_campaign.complaint import BadInput


def read_toml(path, kind, example):
    """The content of a file that is `kind`; `example` says where one to begin with is. Raises BadInput with the file."""
    try:
        text = path.read_bytes().decode()
    except OSError as error:
        raise BadInput(path, error.strerror.lower(), kind, f"check the path; {example}") from error
    except UnicodeDecodeError as error:
        found = f"bytes that are no UTF-8 at {error.start}"
        raise BadInput(path, found, "a text file in UTF-8", "save it as UTF-8") from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise BadInput(path, str(error), "TOML", f"correct it there; {example}") from error
