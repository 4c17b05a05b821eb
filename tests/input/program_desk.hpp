#pragma once
// Where a case of broken input happens: a folder of whole files, made by the programs themselves, and the ways to
// break them.

#include <cstring>
#include <iterator>

#include "airside/controller/instances.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/complaint.hpp"
#include "support/program.hpp"

namespace airside {

/// A folder with whole files, made when a case asks for them, and the ways to break them.
class Desk {
 public:
  const fs::path& folder() const { return folder_.path(); }
  fs::path path(const std::string& name) const { return folder() / name; }
  Outcome run(const std::string& program, const std::vector<std::string>& words) const {
    return run_program(program, words, folder(), scratch_.path());
  }

  /// What a shell makes of `script`, in which $airside is the program.
  Outcome shell(const std::string& script) const {
    return run("/bin/sh", {"-c", "airside=" AIRSIDE_BIN_DIR "/airside; " + script});
  }

  void make(const std::string& words) const {
    const Outcome o = run("airside", split(words));
    ASSERT_EQ(o.code, 0) << words << "\n" << o.err;
  }
  void site() const { make("init ."); }
  void blob() const { make("pretrain --plant rc --days 2 --updates 1 -o a.blob --log log.csv"); }
  void small_blob() const {
    make("pretrain --plant rc --topology 3vav-0fcu-1power --days 2 --updates 1 -o a.blob --log log.csv");
  }
  void weather() const { sim::write_epw(path("w.epw").string(), *sim::synthetic_weather(1), 2021); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  void edit(const std::string& name, const std::string& from, const std::string& to) const {
    write(name, hal::replaced(text_of_file(path(name)), from, to));
  }
  void cut(const std::string& name, std::size_t bytes) const { write(name, text_of_file(path(name)).substr(0, bytes)); }
  /// Replaces column `column` of line `line`, both from 0.
  void set_column(const std::string& name, int line, int column, const std::string& to) const {
    std::string text = text_of_file(path(name));
    std::size_t at = 0;
    for (int i = 0; i < line; ++i) at = text.find('\n', at) + 1;
    for (int i = 0; i < column; ++i) at = text.find(',', at) + 1;
    write(name, text.replace(at, text.find_first_of(",\r\n", at) - at, to));
  }
  void keep_lines(const std::string& name, int lines) const {
    const std::string text = text_of_file(path(name));
    std::size_t at = 0;
    for (int i = 0; i < lines; ++i) at = text.find('\n', at) + 1;
    write(name, text.substr(0, at));
  }
  void drop_line(const std::string& name, int line) const {
    std::string text = text_of_file(path(name));
    std::size_t at = 0;
    for (int i = 0; i < line; ++i) at = text.find('\n', at) + 1;
    write(name, text.erase(at, text.find('\n', at) + 1 - at));
  }
  /// Puts `value` at `offset` of a.blob; with `mend` the checksum is made right again.
  template <class Value>
  void poke(std::size_t offset, Value value, bool mend) const {
    std::string bytes = text_of_file(path("a.blob"));
    ASSERT_LE(offset + sizeof value, bytes.size());
    std::memcpy(bytes.data() + offset, &value, sizeof value);
    if (mend) {
      BlobHeader header;
      std::memcpy(&header, bytes.data(), sizeof header);
      const auto payload = std::as_bytes(std::span(bytes)).subspan(sizeof header, header.payload_bytes);
      const std::uint32_t crc = blob_digest(header, payload);
      std::memcpy(bytes.data() + offsetof(BlobHeader, digest), &crc, sizeof crc);
    }
    write("a.blob", bytes);
  }

  static std::vector<std::string> split(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), std::istream_iterator<std::string>()};
  }

 private:
  TemporaryFolder folder_, scratch_;
};

}  // namespace airside
