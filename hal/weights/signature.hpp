#pragma once
// Ed25519 signatures on weight blobs. libsodium computes; checking asks nothing of the heap.

#include <cstddef>
#include <cstdint>
#include <span>

#include "airside/controller/blob.hpp"
#include "hal/weights/key_ring.hpp"

namespace airside::hal {

/// Writes key id and counter into the header, the digest anew, and the signature behind the payload.
///   signature = Ed25519ph(key, "airside weight blob 1\0" | header | payload)
/// Errors: InputError for bytes that are no whole blob.
/// Source: docs/box-and-safety.md, "Weights that arrive"; docs/formats.md.
void sign_blob(std::span<std::byte> blob, const SecretKey& key, std::uint64_t counter);

/// The header of a blob that is as it was made: whole, and with the digest of its bytes.
/// Errors: InputError that names `path` and the field.
BlobHeader sound_header(std::span<const std::byte> blob, const std::string& path);

/// Checks, in this order: length against the header's, key known and not revoked, signature over every byte before it.
/// Errors: BlobError blob_truncated, blob_magic, blob_size or blob_signature, the field named. Cost: one pass of
/// SHA-512, no heap.
tl::expected<const PublicKey*, BlobError> verify_blob(std::span<const std::byte> blob, const KeyRing& keys);

}  // namespace airside::hal
