#include "tools/run/training/residual_cycles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <string_view>
#include <system_error>

#include "hal/storage/atomic_file.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools {

namespace {

struct CyclesHeader {
  std::array<char, 16> magic{'a', 'i', 'r', 's', 'i', 'd', 'e', ' ', 'c', 'y', 'c', 'l', 'e', 's', ' ', '1'};
  std::uint32_t regressors = ResidualFeatures::count, cycle_min = 0;
  std::uint32_t learned = 0, tried = 0;
};
static_assert(sizeof(CyclesHeader) == 32);

const char* const remedy = "make it anew with airside residual --keep";

std::string bytes_in(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    throw hal::InputError(path, std::generic_category().message(errno), "a file of airside residual --keep", remedy);
  }
  return {std::istreambuf_iterator<char>(in), {}};
}

void put(const std::string& path, const std::string& bytes, const char* option) {
  const auto written = hal::write_file_atomically(path, std::as_bytes(std::span(bytes)));
  if (written) return;
  throw hal::InputError(path, hal::describe(written.error()), "a place that can be written",
                        fmt::format("choose another {}", option));
}

bool is_finite(const ResidualSample& s) {
  return std::isfinite(s.error_k) && std::ranges::all_of(s.x, [](float x) { return std::isfinite(x); });
}

}  // namespace

void ResidualCycles::add(const ResidualCycles& more) {
  learned.insert(learned.end(), more.learned.begin(), more.learned.end());
  tried.insert(tried.end(), more.tried.begin(), more.tried.end());
  cycle_min = more.cycle_min;
}

void write_residual_text(const std::string& path, const ResidualNetwork& network) {
  constexpr std::size_t a_line = 8;
  std::string text;
  for (std::size_t i = 0; i < network.values.size(); ++i) {
    const bool ends = i % a_line == a_line - 1 || i + 1 == network.values.size();
    text += fmt::format("{:.8e}f,{}", network.values[i], ends ? "\n" : " ");
  }
  put(path, text, "--text");
}

void write_cycles(const std::string& path, const ResidualCycles& cycles) {
  CyclesHeader header;
  header.cycle_min = static_cast<std::uint32_t>(cycles.cycle_min);
  header.learned = static_cast<std::uint32_t>(cycles.learned.size());
  header.tried = static_cast<std::uint32_t>(cycles.tried.size());
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  bytes += bytes_of(cycles.learned);
  bytes += bytes_of(cycles.tried);
  put(path, bytes, "--keep");
}

ResidualCycles read_cycles(const std::string& path) {
  const std::string bytes = bytes_in(path);
  CyclesHeader header;
  const CyclesHeader expected;
  if (bytes.size() < sizeof header) {
    throw hal::InputError(path, fmt::format("{} bytes", bytes.size()), "a file of airside residual --keep", remedy);
  }
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != expected.magic) {
    throw hal::InputError(path, "another kind of file", "\"airside cycles 1\" at its beginning", remedy);
  }
  if (header.regressors != expected.regressors) {
    throw hal::InputError(path, fmt::format("{} regressors", header.regressors), fmt::format("{}", expected.regressors),
                          remedy);
  }
  const std::size_t cycles = std::size_t{header.learned} + header.tried;
  if (bytes.size() != sizeof header + cycles * sizeof(ResidualSample)) {
    throw hal::InputError(path, fmt::format("{} bytes", bytes.size()),
                          fmt::format("{} of {} cycles", sizeof header + cycles * sizeof(ResidualSample), cycles),
                          remedy);
  }
  const std::vector<ResidualSample> all = samples_from(std::string_view(bytes).substr(sizeof header));
  if (!std::ranges::all_of(all, is_finite)) {
    throw hal::InputError(path, "a value that is not finite", "numbers", remedy);
  }
  const auto middle = all.begin() + header.learned;
  return {{all.begin(), middle}, {middle, all.end()}, static_cast<int>(header.cycle_min)};
}

}  // namespace airside::tools
