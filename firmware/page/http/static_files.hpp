#pragma once
// The page's own files (firmware/page/web), compiled in: a table by path, no file system.

#include <cstddef>
#include <span>
#include <string_view>

namespace airside::page {

struct StaticFile {
  std::string_view path;  ///< as a browser asks for it
  const char* type;       ///< of Content-Type
  const char* etag;       ///< changes with the content
  std::span<const unsigned char> bytes;
  const char* packed_etag;
  std::span<const unsigned char> packed;  ///< the same by gzip
};

/// All of them; made by embed.cmake.
std::span<const StaticFile> static_files();

/// Null where there is none at this path, which is compared byte for byte.
inline const StaticFile* find_static_file(std::string_view path) {
  for (const StaticFile& file : static_files()) {
    if (file.path == path) return &file;
  }
  return nullptr;
}

}  // namespace airside::page
