#include "firmware/page/inbox/upload_door.hpp"

#include <fmt/format.h>
#include <filesystem>
#include <memory>

#include "airside/controller/instances.hpp"
#include "airside/topologies.hpp"
#include "hal/storage/atomic_file.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/mailbox.hpp"
#include "hal/weights/signature.hpp"

namespace airside::page {
UploadDoor::UploadDoor(const hal::SiteFile& site)
    : keys_dir_(site.keys_dir), inbox_dir_(site.inbox_dir), scope_(site.scope) {
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
  if (wrong != nullptr) return {503, "the box cannot read its keys; its log says why", std::string("keys: ") + wrong};
  const auto key = hal::verify_blob(blob, keys);
  if (!key) {
    return {403,
            fmt::format("{} ({}); boxes take only blobs signed by a key that they know", text_of(key.error().fault),
                        key.error().field),
            ""};
  }
  const std::string signer = fmt::format("key {} ({})", hal::hex_of((*key)->id), (*key)->name.view());
  const auto header = decode_(blob);
  if (!header) {
    return {422, fmt::format("{} ({})", text_of(header.error().fault), header.error().field), signer};
  }
  Answer answer = deliver(blob, *header);
  answer.log = fmt::format("{}, counter {}", signer, header->security_counter);
  return answer;
}

UploadDoor::Answer UploadDoor::deliver(std::span<const std::byte> blob, const BlobHeader& header) const {
  const std::string path = (std::filesystem::path(inbox_dir_) / blob_name).string();
  if (hal::Mailbox::waits(path, header)) {
    return {409, "other weights wait for the daemon already; it looks every 6 min", ""};
  }
  // The folder is shared with other users: a link at its path is not followed, so none of them chooses where this goes.
  const auto inbox = hal::StorageFile::open_existing_dir(inbox_dir_.c_str(), hal::FolderLink::refused);
  const hal::StoreResult<void> written =
      inbox ? hal::write_file_atomically(*inbox, blob_name, blob) : tl::make_unexpected(inbox.error());
  if (written)
    return {202,
            "the daemon looks within 6 min, and then tries the weights for a day, if they are newer than what it took",
            ""};
  const bool full = written.error().fault == hal::StoreFault::no_space;
  return {full ? 507 : 503, fmt::format("the inbox cannot be written: {}", hal::text_of(written.error().fault)), ""};
}

}  // namespace airside::page
