"""Which weights of a library are the same under another signature, which were made from which, and which are not to be
used. Revocation holds for what weights compute, so whoever signs them anew does not bring them back."""

import hashlib

HEADER_BYTES, SIGNATURE_BYTES = 192, 64


def unsigned(data):
    """The bytes without what a signature changes: counter, key, site, digest, signature (docs/formats.md)."""
    if len(data) < HEADER_BYTES + SIGNATURE_BYTES:
        return data
    return data[:40] + data[88:104] + data[136:-SIGNATURE_BYTES]


def content_of(data):
    return hashlib.sha256(unsigned(data)).hexdigest()


class Family:
    """All weights of an index. An entry without `content`, of an older index whose blob is gone, is like no other."""

    def __init__(self, index):
        self.weights = index["weights"]
        self.alike, self.made = {}, {}  # content -> digests; digest -> those that name it as a parent
        for digest, entry in self.weights.items():
            self.alike.setdefault(entry.get("content", digest), []).append(digest)
            for parent in entry.get("parents", []):
                self.made.setdefault(parent, []).append(digest)

    def same(self, digest):
        """It and its copies under other signatures."""
        return [digest, *(d for d in self.alike[self.weights[digest].get("content", digest)] if d != digest)]

    def parents(self, digest):
        """What it was made from, nearest first, each once."""
        return self._walk(digest, lambda at: self.weights[at].get("parents", []))

    def children(self, digest):
        """What was made from it, with copies under other signatures."""
        return self._walk(digest, lambda at: [d for child in self.made.get(at, []) for d in self.same(child)])

    def _walk(self, digest, next_of):
        own = self.same(digest)
        found, seen, waiting = [], set(own), list(own)
        for at in waiting:  # it grows meanwhile
            for other in next_of(at):
                if other in seen or other not in self.weights:
                    continue
                found.append(other)
                copies = [d for d in self.same(other) if d not in seen]
                seen.add(other)
                waiting += copies
        return found

    def why_not(self, digest):
        """Why weights are not to be used: revoked themselves, as a copy, or made from such; empty where they may."""
        for at in self.same(digest):
            if "revoked" in self.weights[at]:
                own = "revoked" if at == digest else f"the same as {at[:12]}, which is revoked"
                return f"{own}: {_reason(self.weights[at])}"
        for parent in self.parents(digest):
            for at in self.same(parent):
                if "revoked" in self.weights[at]:
                    return f"made from {at[:12]}, which is revoked: {_reason(self.weights[at])}"
        return ""


def _reason(entry):
    return f"{entry['revoked']['why']} ({entry['revoked']['at']})"
