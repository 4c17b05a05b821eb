#include "tools/cli/probe/corrected_map.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "hal/points/point_row.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"

namespace airside::tools {

namespace {

struct Line {
  std::string text, end;  ///< end: what follows it, "\n" or "\r\n"
  std::vector<std::string> cells;
  bool changed = false;
};

std::string csv_cell(const std::string& cell) {
  if (cell.find_first_of(",\"") == std::string::npos && !cell.starts_with('#')) return cell;
  std::string text = "\"";
  for (const char c : cell) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

std::vector<Line> lines_of(std::string_view text, const std::string& file) {
  std::vector<Line> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    Line& line = lines.emplace_back();
    std::string_view content = text.substr(0, end);
    line.end = end < text.size() ? "\n" : "";
    if (content.ends_with('\r')) {
      content.remove_suffix(1);
      line.end = "\r\n";
    }
    line.text = content;
    text.remove_prefix(std::min(end + 1, text.size()));
    if (lines.size() == 1 && content.starts_with("\xEF\xBB\xBF")) content.remove_prefix(3);
    while (content.ends_with(' ')) content.remove_suffix(1);
    if (!content.empty() && content.front() != '#') {
      line.cells = hal::split_csv_line(content, file, static_cast<int>(lines.size()));
    }
  }
  return lines;
}

}  // namespace

std::string corrected_map(const std::string& text, const std::string& file, const std::vector<CorrectedRow>& rows) {
  std::vector<Line> lines = lines_of(text, file);
  const auto header = std::ranges::find_if(lines, [](const Line& line) { return !line.cells.empty(); });
  const auto place_of = [&](const std::string& column) {
    const auto at = std::ranges::find(header->cells, column);
    if (at != header->cells.end()) return static_cast<std::size_t>(at - header->cells.begin());
    for (Line& line : lines) {
      if (line.cells.empty()) continue;
      line.cells.push_back(&line == &*header ? column : "");
      line.changed = true;
    }
    return header->cells.size() - 1;
  };
  for (const CorrectedRow& row : rows) {
    for (const auto& [column, cell] : row.cells) {
      const std::size_t place = place_of(column);
      Line& line = lines[static_cast<std::size_t>(row.line - 1)];
      line.cells[place] = cell;
      line.changed = true;
    }
  }
  std::string out;
  for (const Line& line : lines) {
    if (line.changed) {
      for (std::size_t i = 0; i < line.cells.size(); ++i) out += (i == 0 ? "" : ",") + csv_cell(line.cells[i]);
    } else {
      out += line.text;
    }
    out += line.end;
  }
  return out;
}

void write_map(const std::string& path, const std::string& text, bool may_overwrite) {
  if (!may_overwrite && std::filesystem::exists(path)) {
    throw hal::InputError(path, "a file that is already there", "a new file for the corrected map",
                          "choose another name, or give --force to overwrite it");
  }
  static_cast<void>(hal::PointMap::parse(text, path));
  hal::StagedFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace airside::tools
