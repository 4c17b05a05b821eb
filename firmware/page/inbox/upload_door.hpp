#pragma once
// What happens to a body that has come whole: judged like a blob in the inbox, as far as that can be done without the
// controller, then put where the daemon looks.

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "airside/controller/blob.hpp"
#include "firmware/page/http/refusals.hpp"
#include "hal/site/site_file.hpp"

namespace airside::page {

class UploadDoor {
 public:
  static constexpr const char* blob_name = "page.blob";

  struct Answer {
    Said said;        ///< for the sender
    std::string log;  ///< who signed it, for the audit line; empty if nobody
  };

  /// Errors: InputError for a topology that this build does not have.
  explicit UploadDoor(const hal::SiteFile& site);

  /// Length of the longest blob of the room, bytes.
  std::size_t max_bytes() const { return max_bytes_; }

  /// Key and signature (403), what the blob is for and what it holds (422), a blob that lies there and is not older
  /// (409), the folder (503, 507); else it lies in the inbox, whole and synced (202). The daemon judges it again, and
  /// the rest: counter, canary, trial.
  Answer take(std::span<const std::byte> blob) const;

 private:
  Said deliver(std::span<const std::byte> blob, const BlobHeader& header) const;
  Said refuse(int status, const BlobError& why, std::span<const std::byte> blob) const;

  std::string keys_dir_, inbox_dir_, scope_, topology_;
  int cycle_min_ = 0;
  std::size_t max_bytes_ = 0;
  std::function<tl::expected<BlobHeader, BlobError>(std::span<const std::byte>)> decode_;
};

}  // namespace airside::page
