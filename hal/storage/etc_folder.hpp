#pragma once
// A folder that a box's units may not write.

#include <filesystem>
#include <string>

namespace airside::hal {

/// Whether a folder lies below /etc, which systemd's ProtectSystem=strict keeps read-only for the box's units.
inline bool is_below_etc(const std::string& folder) {
  std::error_code failed;
  const auto at = std::filesystem::absolute(folder, failed).lexically_normal().string();
  return !folder.empty() && at.starts_with("/etc/");
}

/// What the package has in its place, by the table of the site file: "state", "log" or "inbox".
inline std::string folder_of_box(const std::string& table) {
  return table == "state" ? "/var/lib/airside" : "/var/lib/airside/" + table;
}

}  // namespace airside::hal
