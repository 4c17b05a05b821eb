#pragma once
// Blob files on disk, and refusals that a person can act on.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "airside/controller/blob.hpp"
#include "airside/network/kernels/kernels.hpp"

namespace airside::hal {

/// Reads a blob file whole.  Errors: InputError for a missing, empty or far too large file.
std::vector<std::byte> read_blob_file(const std::string& path);

/// What write_blob_file() would find wrong with the place, before long work is done for it.
/// Errors: InputError naming the path: a folder that is missing or not this user's to write, or no file there but a
///   folder, a pipe or a device.
void check_blob_place(const std::string& path);

/// Writes to a temporary file beside `path`, syncs and renames: the file is the old or the new one.
/// Errors: InputError naming the path, also as check_blob_place().
void write_blob_file(const std::string& path, std::span<const std::byte> blob);

/// Why a blob is refused, for people: what was found, what was expected, what to do.
struct BlobComplaint {
  const char *found, *expected, *remedy;
};
BlobComplaint complaint_of(Fault fault);
/// The same as InputError.
[[noreturn]] void throw_blob_error(const BlobError& error, const std::string& place);

/// Of a blob for another control cycle than the site's, with both. Shape: bytes at least a header.
[[noreturn]] void throw_cycle_error(std::span<const std::byte> bytes, ControlCycle site, const std::string& place);

/// Decodes into `payload`.  Errors: InputError naming `place` and the field.
template <Topology T, int Parameters>
BlobHeader decode_blob(std::span<const std::byte> bytes, const std::string& scope, const std::string& place,
                       BlobPayload<T, Parameters>& payload) {
  const auto header = BlobCodec<T, Parameters>::decode(bytes, scope, payload);
  if (!header && header.error().fault == Fault::blob_cycle) throw_cycle_error(bytes, payload.cycle, place);
  if (!header) throw_blob_error(header.error(), place);
  return *header;
}

/// The kernels that this machine runs best; AIRSIDE_KERNELS=strict|avx2|avx512 in the environment chooses others.
/// Errors: InputError for another word.
Kernels<float> box_kernels();

}  // namespace airside::hal
