#include "hal/weights/blob_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "hal/storage/atomic_file.hpp"
#include "hal/text/input_error.hpp"

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

void check_blob_place(const std::string& path) {
  std::error_code ignored;
  const auto there = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) {
    throw InputError(path, "a folder, a pipe or a device, which the new file would replace", "the name of a file",
                     "choose another output path");
  }
  BlobHeader header;
  std::ifstream before(path, std::ios::binary);
  if (before.read(reinterpret_cast<char*>(&header), sizeof header.magic) && header.magic != BlobHeader{}.magic) {
    throw InputError(path, "another kind of file, which the weights would replace", "a new name, or that of weights",
                     "choose another output path");
  }
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK) == 0) return;
  throw InputError(path, fmt::format("a folder that cannot be written: {}", std::strerror(errno)),
                   "a folder that can be written", "choose another output path");
}

void write_blob_file(const std::string& path, std::span<const std::byte> blob) {
  check_blob_place(path);
  const StoreResult<void> written = write_file_atomically(path, blob);
  if (!written) {
    throw InputError(path, describe(written.error()), "a folder that can be written", "choose another output path");
  }
}

BlobComplaint complaint_of(Fault fault) {
  switch (fault) {
    case Fault::blob_truncated:
      return {"a blob that ends early", "as many bytes as its header says", "copy the file again, whole"};
    case Fault::blob_magic:
      return {"another kind of file", "a weight blob (it begins with AIRSIDEB)",
              "give a file made by `airside pretrain` or `airside transfer`"};
    case Fault::blob_version:
      return {"a format version that this build does not read",
              "version 1, 2 with a residual network, or 3 of another control cycle",
              "use the airside version that wrote it, or make the blob again"};
    case Fault::blob_architecture:
      return {"other byte order or float format", "little-endian IEEE 754", "make the blob on a little-endian machine"};
    case Fault::blob_digest: return {"a checksum that does not match", "an undamaged blob", "copy the file again"};
    case Fault::blob_topology:
      return {"weights of another topology", "the site's topology",
              "pretrain with this site file, or correct `topology` in it"};
    case Fault::blob_units:
      return {"other signals or units", "the signals in the order of docs/method.md 3.1",
              "make the blob again with this version"};
    case Fault::blob_cycle:
      return {"weights that predict another length of the control cycle", "[controller] cycle_min of the site",
              "pretrain or transfer with this site file, or correct cycle_min in it"};
    case Fault::blob_scope:
      return {"a blob for another site", "this site's scope or none",
              "transfer it to this site, or correct `scope` in the site file"};
    case Fault::blob_value:
      return {"numbers that are not finite or out of bounds, or that act wildly",
              "finite weights within +-1000, sane here",
              "train again; these weights diverged, were damaged, or are another room's"};
    case Fault::blob_signature:
      return {"no signature of a key that is known here and not revoked", "a blob signed by one of [weights] keys",
              "airside sign it, or put the signer's .pub into that folder"};
    case Fault::blob_counter:
      return {"a blob as old as one that was taken, or older", "a higher counter",
              "airside sign it again, if it is really to be taken"};
    case Fault::counter_unknown:
      return {
          "nothing that says which blobs of this key were taken: state and counters are lost",
          "a counter above the last one that was taken",
          "write a line `KEY_ID LAST_COUNTER` into the file `counters` of [weights] keys (both stand in `airside blob "
          "inspect` of the last blob that was pushed; 0 takes any), then push again"};
    case Fault::blob_taken_back:
      return {"a rollback that came after it", "a blob that nobody took back", "push it again, if it is to be taken"};
    case Fault::state_invalid:
      return {"no room for a copy of the weights before", "a way back", "make room in the state folder"};
    default:
      return {"a length that does not fit", "the topology's number of values",
              "copy the file again, in binary and not as text, or make the blob again"};
  }
}

void throw_blob_error(const BlobError& error, const std::string& place) {
  const BlobComplaint complaint = complaint_of(error.fault);
  throw InputError(place + ": " + error.field, complaint.found, complaint.expected, complaint.remedy);
}

void throw_cycle_error(std::span<const std::byte> bytes, ControlCycle site, const std::string& place) {
  BlobHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  throw InputError(place + ": cycle_min", fmt::format("weights that predict a cycle of {} min", cycle_min_of(header)),
                   fmt::format("a cycle of {} min, as the site has it", site.minutes()),
                   fmt::format("pretrain or transfer with this site file, or set cycle_min = {} in [controller]",
                               cycle_min_of(header)));
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
