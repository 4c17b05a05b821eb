#include "sim/energyplus/replay/eso.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <sstream>
#include <string_view>

#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

constexpr std::string_view end_of_dictionary = "End of Data Dictionary", end_of_series = "End of Data";

std::string upper_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// "7,1,INTERIOR 1,Zone Mean Air Temperature [C] !TimeStep" names series 7 "INTERIOR 1,ZONE MEAN AIR TEMPERATURE".
std::string series_name(std::string_view line) {
  for (int skipped = 0; skipped < 2; ++skipped) line.remove_prefix(std::min(line.find(','), line.size() - 1) + 1);
  return upper_case(std::string(line.substr(0, line.rfind(" ["))));
}

std::size_t number_of(std::string_view line) {
  std::size_t number = 0;
  std::from_chars(line.data(), line.data() + line.size(), number);
  return number;
}

class LineWalk {
 public:
  explicit LineWalk(std::string_view text) : rest_(text) {}
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const auto end = std::min(rest_.find('\n'), rest_.size());
    line = rest_.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return true;
  }

 private:
  std::string_view rest_;
};

}  // namespace

EsoFile::EsoFile(const std::filesystem::path& file, Periods periods) : file_(file.string()) {
  const auto refuse = [this](const std::string& found) {
    throw hal::InputError(file_, found, "the outputs of one EnergyPlus run, to its end", "run the engine again");
  };
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse("no such file");
  std::ostringstream whole;
  whole << in.rdbuf();
  const std::string text = std::move(whole).str();

  // Numbers below this are the file's own: dates and titles.
  constexpr std::size_t first_series = 7, environment = 1;
  std::vector<std::vector<double>*> by_number;
  LineWalk lines(text);
  std::string_view line;
  bool defined = false, ended = false;
  while (!defined && lines.next(line)) {
    defined = line == end_of_dictionary;
    const std::size_t number = number_of(line);
    if (defined || number < first_series) continue;
    by_number.resize(std::max(by_number.size(), number + 1), nullptr);
    by_number[number] = &series_[series_name(line)];
  }
  int environments = 0;
  while (!ended && lines.next(line)) {
    ended = line == end_of_series;
    const std::size_t number = number_of(line);
    if (number == environment && ++environments > 1) {
      if (periods == Periods::one) refuse("more than one run period");
      for (auto& [name, values] : series_) values.clear();
    }
    if (ended || number >= by_number.size() || by_number[number] == nullptr) continue;
    const auto comma = line.find(',');
    if (comma == std::string_view::npos) refuse("the line '" + std::string(line) + "'");
    std::string_view field = line.substr(comma + 1);
    field.remove_prefix(std::min(field.find_first_not_of(' '), field.size()));
    double value = 0;
    if (std::from_chars(field.data(), field.data() + field.size(), value).ec != std::errc())
      refuse("the line '" + std::string(line) + "'");
    by_number[number]->push_back(value);
  }
  if (!ended) refuse("a file without an end");
}

const std::vector<double>& EsoFile::of(const std::string& name) const {
  const auto found = series_.find(upper_case(name));
  if (found == series_.end() || found->second.empty()) {
    throw hal::InputError(file_, "no values of '" + name + "'", "an output of the model",
                          "compare the model's zones, nodes and meters with ModelNames");
  }
  return found->second;
}

}  // namespace airside::sim
