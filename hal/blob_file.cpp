#include "hal/blob_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "hal/atomic_file.hpp"
#include "hal/input_error.hpp"

namespace airside::hal {

namespace {
constexpr std::uintmax_t largest_blob_bytes = 4u << 20;
}

std::vector<std::byte> read_blob_file(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) {
    throw InputError(path, error.message(), "a weight blob", "make one with `airside pretrain` or `airside transfer`");
  }
  if (size < sizeof(BlobHeader) || size > largest_blob_bytes) {
    throw InputError(path, fmt::format("{} bytes", size),
                     fmt::format("{} to {} bytes", sizeof(BlobHeader), largest_blob_bytes),
                     "copy the file again, whole; it is no weight blob as it is");
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  std::ifstream in(path, std::ios::binary);
  if (!in.is_open()) {
    throw InputError(path, std::strerror(errno), "a weight blob that this user may read",
                     "give it to the user or the group that runs this, such as by chgrp airside");
  }
  if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    throw InputError(path, "a file that ends early", fmt::format("{} bytes", size), "copy the file again");
  }
  return bytes;
}

void write_blob_file(const std::string& path, std::span<const std::byte> blob) {
  const StoreResult<void> written = write_file_atomically(path, blob);
  if (!written) {
    throw InputError(path, describe(written.error()), "a folder that can be written", "choose another output path");
  }
}

void throw_blob_error(const BlobError& error, const std::string& place) {
  const std::string where = place + ": " + error.field;
  switch (error.fault) {
    case Fault::blob_truncated:
      throw InputError(where, "a blob that ends early", "as many bytes as its header says",
                       "copy the file again, whole");
    case Fault::blob_magic:
      throw InputError(where, "another kind of file", "a weight blob (it begins with AIRSIDEB)",
                       "give a file made by `airside pretrain` or `airside transfer`");
    case Fault::blob_version:
      throw InputError(where, "a format version that this build does not read", "version 1",
                       "use the airside version that wrote it, or make the blob again");
    case Fault::blob_architecture:
      throw InputError(where, "other byte order or float format", "little-endian IEEE 754",
                       "make the blob on a little-endian machine");
    case Fault::blob_digest:
      throw InputError(where, "a checksum that does not match", "an undamaged blob", "copy the file again");
    case Fault::blob_topology:
      throw InputError(where, "weights of another topology", "the site's topology",
                       "pretrain with this site file, or correct `topology` in it");
    case Fault::blob_units:
      throw InputError(where, "other signals or units", "the signals of spec 3.1 in order",
                       "make the blob again with this version");
    case Fault::blob_scope:
      throw InputError(where, "a blob for another site", "this site's scope or none",
                       "transfer it to this site, or correct `scope` in the site file");
    case Fault::blob_value:
      throw InputError(where, "a number that is not finite or out of bounds", "finite weights within +-1000",
                       "train again; these weights diverged or were damaged");
    default:
      throw InputError(where, "a length that does not fit", "the topology's number of values", "make the blob again");
  }
}

Kernels<float> box_kernels() {
  const char* wish = std::getenv("AIRSIDE_KERNELS");
  if (wish == nullptr || *wish == '\0') return select_kernels<float>();
  const std::string_view word(wish);
  if (word == "strict") return float_kernels(KernelKind::strict);
  if (word == "avx2") return float_kernels(KernelKind::avx2);
  if (word == "avx512") return float_kernels(KernelKind::avx512);
  throw InputError("environment: AIRSIDE_KERNELS", "'" + std::string(word) + "'", "strict, avx2 or avx512",
                   "unset it to let airside choose");
}

}  // namespace airside::hal
