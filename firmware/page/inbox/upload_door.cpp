#include "firmware/page/inbox/upload_door.hpp"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>

#include "airside/controller/instances.hpp"
#include "airside/topologies.hpp"
#include "firmware/page/inbox/wishes.hpp"
#include "hal/storage/atomic_file.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/mailbox.hpp"
#include "hal/weights/signature.hpp"

namespace airside::page {
namespace {

const Refused& refused_as(const BlobError& why) {
  switch (why.fault) {
    case Fault::blob_truncated: return refusals::weights_truncated;
    case Fault::blob_magic: return refusals::weights_no_blob;
    case Fault::blob_version: return refusals::weights_version;
    case Fault::blob_architecture: return refusals::weights_architecture;
    case Fault::blob_topology: return refusals::weights_topology;
    case Fault::blob_units: return refusals::weights_units;
    case Fault::blob_digest: return refusals::weights_damaged;
    case Fault::blob_value: return refusals::weights_value;
    case Fault::blob_scope: return refusals::weights_scope;
    case Fault::blob_cycle: return refusals::weights_cycle;
    case Fault::blob_signature:
      return std::string_view(why.field) == "key_id" ? refusals::weights_key : refusals::weights_signature;
    default: return refusals::weights_size;
  }
}

}  // namespace

UploadDoor::UploadDoor(const hal::SiteFile& site)
    : keys_dir_(site.keys_dir),
      inbox_dir_(site.inbox_dir),
      scope_(site.scope),
      topology_(site.topology),
      cycle_min_(cycle_of_minutes(site.cycle_min).minutes()) {
  with_topology(site.topology.c_str(), [&]<class T>(T) {
    auto payload = std::make_shared<typename WeightBlob<T>::Payload>();
    payload->site = parse_shape(site.topology.c_str());
    payload->cycle = cycle_of_minutes(site.cycle_min);
    max_bytes_ = WeightBlob<T>::size(RoomHead<T>::states, ResidualNetwork::parameters, payload->site);
    decode_ = [payload, scope = scope_](std::span<const std::byte> blob) {
      return WeightBlob<T>::decode(blob, scope, *payload);
    };
  });
  if (!decode_) {
    throw hal::InputError(site.path + ": topology", "'" + site.topology + "'", "a topology of this build",
                          "build with it in AIRSIDE_TOPOLOGIES");
  }
}

UploadDoor::Answer UploadDoor::take(std::span<const std::byte> blob) const {
  hal::KeyRing keys;
  // Each time, so that a key that was revoked is refused at once; as the daemon reads them.
  const char* wrong = keys.reload(keys_dir_.c_str(), [](const char*, const char*) {});
  if (wrong != nullptr) return {refusal(503, refusals::keys_unreadable), std::string("keys: ") + wrong};
  const auto key = hal::verify_blob(blob, keys);
  if (!key) {
    Answer answer{refuse(403, key.error(), blob), ""};
    answer.said.text += "; boxes take only blobs signed by a key that they know";
    return answer;
  }
  const std::string signer = fmt::format("key {} ({})", hal::hex_of((*key)->id), (*key)->name.view());
  const auto header = decode_(blob);
  if (!header) return {refuse(422, header.error(), blob), signer};
  return {deliver(blob, *header), fmt::format("{}, counter {}", signer, header->security_counter)};
}

Said UploadDoor::refuse(int status, const BlobError& why, std::span<const std::byte> blob) const {
  Said said = refusal(status, refused_as(why));
  said.field = why.field;
  said.text += fmt::format(" ({})", why.field);
  BlobHeader header;
  if (blob.size() < sizeof header) {
    said.found = std::to_string(blob.size());
    said.expected = std::to_string(sizeof header);
    return said;
  }
  std::memcpy(&header, blob.data(), sizeof header);
  switch (why.fault) {
    case Fault::blob_truncated: {
      const bool has_header = why.field != std::string_view("header");
      said.found = std::to_string(blob.size());
      said.expected =
          std::to_string(sizeof header + blob_signature_bytes + (has_header ? std::uint64_t{header.payload_bytes} : 0));
      break;
    }
    case Fault::blob_size: said.found = std::to_string(blob.size()); break;
    case Fault::blob_version:
      said.found = std::to_string(header.format_version);
      said.expected = fmt::format("{}-{}", blob_version_plain, blob_version_cycle);
      break;
    case Fault::blob_topology: said.expected = topology_; break;
    case Fault::blob_scope: said.expected = scope_; break;
    case Fault::blob_cycle:
      said.found = std::to_string(cycle_min_of(header));
      said.expected = std::to_string(cycle_min_);
      break;
    default: break;
  }
  return said;
}

Said UploadDoor::deliver(std::span<const std::byte> blob, const BlobHeader& header) const {
  const std::string path = (std::filesystem::path(inbox_dir_) / blob_name).string();
  if (hal::Mailbox::waits(path, header)) {
    return refusal(409, refusals::weights_waiting);
  }
  // The folder is shared with other users: a link at its path is not followed, so none of them chooses where this goes.
  const auto inbox = hal::StorageFile::open_existing_dir(inbox_dir_.c_str(), hal::FolderLink::refused);
  const hal::StoreResult<void> written =
      inbox ? hal::write_file_atomically(*inbox, blob_name, blob) : tl::make_unexpected(inbox.error());
  if (!written) return inbox_refusal(written.error().fault);
  return {202,
          "the daemon looks within 6 min, and then tries the weights for a day, if they are newer than what it took"};
}

}  // namespace airside::page
