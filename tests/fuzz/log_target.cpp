// Logs: what is taken is written back and read back to the same bits, and the daemon's log goes on after any file.

#include <algorithm>
#include <bit>
#include <cmath>

#include "fuzz/folder.hpp"
#include "fuzz/target.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/log/row_log.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::fuzz {
namespace {

const hal::TopologyCounts& counts() {
  static const hal::TopologyCounts one{"1vav-0fcu-1power", 1, 0, 1};
  return one;
}

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

std::string written(const hal::Log& log) {
  std::string text = hal::log_header(counts(), log.has_controller, log.extra_columns);
  for (const hal::LogRow& row : log.rows) {
    char line[hal::max_log_row_text];
    const std::size_t size = hal::format_log_row(line, row, log.has_controller);
    if (size == 0) return {};
    text.append(line, size);
  }
  return text;
}

bool read(View input) {
  Cursor in(input);
  hal::LogReadOptions options;
  options.keep_missing = in.byte() % 2 != 0;
  return taken([&] {
    const hal::Log log = hal::read_log_text(text_of(in.rest()), "log.csv", counts(), options);
    FUZZ_CLAIM(!log.rows.empty() && log.summary.rows == log.rows.size());
    for (std::size_t i = 0; i < log.rows.size(); ++i) {
      const hal::LogRow& row = log.rows[i];
      FUZZ_CLAIM(row.value.size() == 6 && row.extra.size() == log.extra_columns.size());
      FUZZ_CLAIM(row.time.second_of_day() % row_s == 0 && (i == 0 || log.rows[i - 1].time < row.time));
      for (const double v : row.value) FUZZ_CLAIM(options.keep_missing ? !std::isinf(v) : std::isfinite(v));
    }
    const std::string text = written(log);
    if (text.empty()) return;
    const hal::Log again = hal::read_log_text(text, "again.csv", counts(), options);
    FUZZ_CLAIM(again.rows.size() == log.rows.size() && again.extra_columns.size() == log.extra_columns.size());
    for (std::size_t i = 0; i < log.rows.size(); ++i) {
      FUZZ_CLAIM(again.rows[i].time == log.rows[i].time);
      for (std::size_t k = 0; k < 6; ++k) FUZZ_CLAIM(same(again.rows[i].value[k], log.rows[i].value[k]));
      FUZZ_CLAIM(same(again.rows[i].setpoint_degc, log.rows[i].setpoint_degc));
      FUZZ_CLAIM(same(again.rows[i].controller.confidence, log.rows[i].controller.confidence));
    }
    FUZZ_CLAIM(written(again) == text);
  });
}

hal::LogRow example_row(std::int64_t k) {
  hal::LogRow row = hal::make_log_row(counts());
  row.time = {1625097600 + k * row_s};
  row.value = {25.5, 1, 3.25, 18, 30.1, 0};
  row.setpoint_degc = 20.5;
  row.controller.mode = "learn";
  row.controller.reason = row.controller.fault = "none";
  row.controller.confidence = 0.5;
  return row;
}

std::string example(bool controller, int rows) {
  std::string text = hal::log_header(counts(), controller);
  for (int k = 0; k < rows; ++k) {
    char line[hal::max_log_row_text];
    text.append(line, hal::format_log_row(line, example_row(k), controller));
  }
  return text;
}

std::vector<Bytes> seeds() {
  const auto with = [](char options, const std::string& text) { return bytes_of(options + text); };
  const std::string header =
      "time,room_temp_1_degc,vav_on_1,power_1_kw,mau_temp_degc,outdoor_temp_degc,rain,setpoint_degc";
  return {
      with('\0', example(true, 3)), with('\0', example(false, 2)),
      with('\1', header + ",note\r\n2021-07-01T00:06:00,,1,nan,18,30,0,20.5,\"a,\"\"b\"\r\n"),
      with('\0', "\xEF\xBB\xBF" + header + "\n2021-07-01 00:06,25,1,2,3,4,0,20\n2021-07-01 01:06,25,1,2,3,4,0,20\n")};
}

std::vector<std::string> words() {
  return {"time",
          "room_temp_1_degc",
          "vav_on_1",
          "power_1_kw",
          "mau_temp_degc",
          "outdoor_temp_degc",
          "rain",
          "setpoint_degc",
          "supply_temp_degc",
          "mode",
          "reason",
          "confidence",
          "fault",
          "loss_strb",
          "a_network_degc",
          "2021-07-01T00:06:00",
          "2021-07-01T00:12:00",
          "T24:00",
          "9999-12-31T23:54:00",
          "0000-01-01T00:00:00",
          "nan",
          "inf",
          "-0",
          "1e308",
          "5e-324",
          "\"\"",
          ",",
          "room_temp_2_degc"};
}

// ---- the daemon's log

bool follow(View input) {
  static const Folder folder("fuzz_rows");
  static constexpr const char* names[] = {"airside-2021-07-01.csv", "airside-2021-07-01_01.csv"};
  Cursor in(input);
  const unsigned choice = in.byte();
  const hal::LogPosition committed{18809, choice & 1U, in.word()};
  const View text = in.rest();
  const auto cut = static_cast<std::size_t>(std::ranges::find(text, std::uint8_t{0x1E}) - text.begin());
  folder.write(names[0], text.first(cut));
  if (cut < text.size()) {
    folder.write(names[1], text.subspan(cut + 1));
  } else {
    folder.remove(names[1]);
  }
  hal::LogRow row = example_row(0);
  hal::LogPosition end;
  bool followed = false;
  {
    auto log = hal::RowLog::open(folder.path(), counts(), {.max_files = 3, .max_file_bytes = 600}, hal::Sync::none);
    FUZZ_CLAIM(log.has_value());
    const auto resumed = log->resume((choice & 2) != 0 ? committed : hal::LogPosition{});
    FUZZ_CLAIM(resumed || resumed.error().fault == hal::StoreFault::log_shorter);
    if ((choice & 2) != 0 && resumed && committed.bytes > 0) FUZZ_CLAIM(log->position() == committed);
    followed = log->position().bytes > 0;
    if (followed) row.time = {log->last_time().seconds + row_s};
    if (row.time.seconds > 250'000'000'000) row.time = {0};  // behind the last year that has four digits
    const auto added = log->append(row);
    if (!added) FUZZ_CLAIM(added.error().fault == hal::StoreFault::out_of_order);
    if (added) FUZZ_CLAIM(log->last_time() == row.time && !log->append(row));
    FUZZ_CLAIM(log->sync().has_value());
    end = log->position();
    if (!added) row.time = log->last_time();
  }
  auto log = hal::RowLog::open(folder.path(), counts(), {.max_files = 3, .max_file_bytes = 600}, hal::Sync::none);
  FUZZ_CLAIM(log.has_value() && log->position() == end && log->last_time() == row.time);
  for (int k = 1; k < 9; ++k) {
    FUZZ_CLAIM(log->files() <= 3);
    row.time = {row.time.seconds + k * row_s};
    if (row.time.seconds < 250'000'000'000) FUZZ_CLAIM(log->append(row).has_value());
  }
  // What this run has added goes; the two files are written anew for the next.
  for (std::filesystem::directory_iterator entry(folder.path()); const auto& file : entry) {
    if (file.path().filename() != names[0]) std::filesystem::remove(file.path());
  }
  return followed;
}

std::vector<Bytes> follow_seeds() {
  const std::string front = std::string("\0\0\0", 3), committed = std::string("\2\1\x80", 3);
  const std::string one = example(true, 2), two = hal::log_header(counts(), true) + example(true, 4).substr(one.size());
  return {bytes_of(front + one),
          bytes_of(front + one + '\x1E' + two),
          bytes_of(committed + one),
          bytes_of(front + one.substr(0, one.size() - 30)),
          bytes_of(front + hal::log_header(counts(), true)),
          bytes_of(front)};
}

}  // namespace

const Target log_csv{"log_csv", 1200, read, nullptr, seeds, words};
const Target row_log{"row_log", 1200, follow, nullptr, follow_seeds, words};

}  // namespace airside::fuzz
