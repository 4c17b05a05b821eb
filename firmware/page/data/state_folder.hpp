#pragma once
// The daemon's folder as the page reads it: never by way of a link, never waiting for a pipe.

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/storage/storage_file.hpp"

namespace airside::page {

constexpr std::uint64_t max_status_bytes = 65536;

/// A regular file of at most `max_bytes`, and how long it is. Not open where there is none.
hal::StorageFile open_in(const std::string& folder, const char* name, std::uint64_t max_bytes, std::uint64_t& bytes);

/// What `file` of `bytes` holds; null or discarded where it is not whole or no JSON.
nlohmann::json json_in(const hal::StorageFile& file, std::uint64_t bytes);

/// status.json, read again where it has changed.
class StatusReader {
 public:
  explicit StatusReader(std::string state_dir) : dir_(std::move(state_dir)) {}

  /// Looks whether there is another one. True: there is.
  bool refresh();
  /// As it was read; empty where there is none.
  const std::string& text() const { return text_; }
  /// The same parsed; null where it is no object.
  const nlohmann::json& object() const { return object_; }
  /// Since it was written, s; not finite where there is none.
  double age_s() const;

 private:
  std::string dir_, text_;
  nlohmann::json object_;
  std::uint64_t inode_ = 0;
  std::int64_t changed_ns_ = 0;
};

/// A member that may be missing or null.
inline double number_of(const nlohmann::json& object, const char* name) {
  const auto at = object.is_object() ? object.find(name) : object.end();
  return at != object.end() && at->is_number() ? at->get<double>() : std::numeric_limits<double>::quiet_NaN();
}
inline std::string text_in(const nlohmann::json& object, const char* name) {
  const auto at = object.is_object() ? object.find(name) : object.end();
  return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

/// One line; bytes that are no UTF-8 are replaced.
inline std::string dumped(const nlohmann::json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace airside::page
