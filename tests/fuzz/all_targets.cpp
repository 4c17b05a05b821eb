#include "fuzz/target.hpp"

namespace airside::fuzz {

std::vector<const Target*> all_targets() {
  return {&blob,       &blob_head,  &signed_blob,   &keys,          &site_file,   &point_map, &register_codec,
          &modbus_tcp, &modbus_rtu, &durable_store, &small_records, &log_csv,     &row_log,   &mailbox,
          &epw,        &room_file,  &json_patch,    &readings,      &http_request};
}

}  // namespace airside::fuzz
