#pragma once
// Folders of tests, in memory where the machine has a memory file system, and their content as an image.

#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace airside::hal {

using FileImage = std::vector<std::byte>;
using FolderImage = std::map<std::string, FileImage>;

/// An empty folder of this process, removed at the end.
class TestFolder {
 public:
  explicit TestFolder(const std::string& name, bool in_memory = true) {
    const std::filesystem::path base = in_memory && std::filesystem::is_directory("/dev/shm")
                                           ? std::filesystem::path("/dev/shm")
                                           : std::filesystem::temp_directory_path();
    path_ = base / ("airside_" + name + "_" + std::to_string(::getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directory(path_);
  }
  ~TestFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  const char* c_str() const { return path_.c_str(); }
  std::filesystem::path file(const std::string& name) const { return path_ / name; }

  FolderImage image() const {
    FolderImage image;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) {
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      FileImage& bytes = image[entry.path().filename().string()];
      for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
    }
    return image;
  }
  /// Makes the folder hold exactly this image.
  void restore(const FolderImage& image) const {
    for (const auto& entry : std::filesystem::directory_iterator(path_)) {
      if (!image.count(entry.path().filename().string())) std::filesystem::remove(entry.path());
    }
    for (const auto& [name, bytes] : image) {
      std::ofstream file(path_ / name, std::ios::binary | std::ios::trunc);
      file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
  }

 private:
  std::filesystem::path path_;
};

}  // namespace airside::hal
