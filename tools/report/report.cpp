#include "tools/report/report.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_folder.hpp"
#include "tools/report/charts/downsample.hpp"
#include "tools/report/charts/report_text.hpp"
#include "tools/report/charts/series_look.hpp"
#include "tools/report/charts/svg_chart.hpp"
#include "tools/report/page_parts.hpp"

namespace airside::tools {
namespace {

using nlohmann::json;

void append(std::string& page, const char* const* pieces) {
  for (; *pieces; ++pieces) page += *pieces;
}

void misfit(const std::string& title, const std::string& found, const std::string& expected) {
  throw hal::InputError("report: \"" + title + '"', found, expected, "give every x, category or column one value");
}

void check(const LineChart& chart) {
  for (const ChartSeries& s : chart.series) {
    if (s.y.size() != chart.x.size() && s.y.size() != 1) {
      misfit(chart.title, fmt::format("{} values in series \"{}\"", s.y.size(), s.name),
             fmt::format("{} as in x, or one", chart.x.size()));
    }
  }
  for (std::size_t i = 0; i < chart.x.size(); ++i) {
    if (!std::isfinite(chart.x[i]) || (i > 0 && !(chart.x[i] > chart.x[i - 1]))) {
      misfit(chart.title, fmt::format("x that does not increase at entry {}", i), "finite, increasing x");
    }
  }
}

void check(const BarChart& chart) {
  for (const BarGroup& g : chart.groups) {
    if (g.y.size() != chart.categories.size()) {
      misfit(chart.title, fmt::format("{} bars in group \"{}\"", g.y.size(), g.name),
             fmt::format("{} as there are categories", chart.categories.size()));
    }
  }
}

void check(const ReportTable& table) {
  for (const TableRow& row : table.rows) {
    if (row.cells.size() != table.columns.size()) {
      misfit(table.title, fmt::format("{} cells in row \"{}\"", row.cells.size(), row.name),
             fmt::format("{} as there are columns", table.columns.size()));
    }
  }
}

void check(const ReportNote&) {}
void check(const PictureRow&) {}

/// Five significant digits are more than a screen can show; null is a gap.
json numbers(const std::vector<double>& values, bool positive_only) {
  json list = json::array();
  for (const double v : values) {
    if (!std::isfinite(v) || (positive_only && v <= 0)) {
      list.push_back(nullptr);
    } else {
      list.push_back(std::stod(fmt::format("{:.5g}", v)));
    }
  }
  return list;
}

json chart_json(const LineChart& full, std::size_t points) {
  const LineChart chart = downsample(full, points);
  json j = {{"title", valid_utf8(chart.title)},
            {"unit", valid_utf8(chart.unit)},
            {"xLabel", valid_utf8(chart.x_label)},
            {"time", chart.x_is_time},
            {"log", chart.log_axis},
            {"decimals", chart.decimals},
            {"bandName", valid_utf8(chart.band_name)}};
  j["x"] = chart.x;
  if (chart.x_is_time) {
    for (json& x : j["x"]) x = static_cast<std::int64_t>(std::llround(x.get<double>()));
  }
  j["yMin"] = chart.y_min ? json(*chart.y_min) : json();
  j["yMax"] = chart.y_max ? json(*chart.y_max) : json();
  j["yNames"] = json::array();
  for (const std::string& name : chart.y_names) j["yNames"].push_back(valid_utf8(name));
  j["raised"] = valid_utf8(chart.raised);
  j["bands"] = json::array();
  for (const ChartBand& b : chart.bands) j["bands"].push_back({b.from, b.to});
  j["series"] = json::array();
  j["stretches"] = json::array();
  for (const ChartStretch& s : chart.stretches) {
    j["stretches"].push_back({s.from, s.to, s.kind, valid_utf8(s.why.empty() ? s.name : s.name + ": " + s.why)});
  }
  j["stretchesName"] = valid_utf8(chart.stretches_name);
  j["otherwise"] = valid_utf8(chart.otherwise);
  const std::vector<SeriesLook> looks = looks_of(chart);
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const ChartSeries& s = chart.series[i];
    json y = numbers(s.y, chart.log_axis);
    j["series"].push_back({{"name", valid_utf8(s.name)},
                           {"colour", looks[i].colour},
                           {"muted", looks[i].muted},
                           {"dash", looks[i].dash},
                           {"step", s.stepped},
                           {"y", s.y.size() == 1 && chart.x.size() != 1 ? y[0] : y}});
  }
  return j;
}

std::string heading(const std::string& title, const std::string& note) {
  std::string html = "<h2>" + escape_markup(title) + "</h2>\n";
  if (!note.empty()) html += "<p class=\"note\">" + escape_markup(note) + "</p>\n";
  return html;
}

struct BlockWriter {
  std::string& page;
  json& charts;
  std::size_t points;

  void operator()(const LineChart& chart) const {
    page += "<section>" + heading(chart.title, chart.note);
    if (!chart.stretches.empty()) {
      page += "<ul class=\"stretches\">";
      for (const ChartStretch& kind : kinds_of(chart.stretches))
        page += fmt::format("<li><i class=\"{}\"></i>{}</li>", kind.kind, escape_markup(kind.name));
      page += "</ul>";
    }
    page += fmt::format("<div class=\"chart\" data-chart=\"{}\"></div></section>\n", charts.size());
    charts.push_back(chart_json(chart, points));
  }

  void operator()(const BarChart& chart) const {
    page += "<section>" + heading(chart.title, chart.note) + "<div class=\"bars\"><ul class=\"keys\">";
    const std::vector<SeriesLook> looks = looks_of(chart);
    for (std::size_t g = 0; g < looks.size(); ++g) {
      page += fmt::format("<li><button type=\"button\" data-group=\"{}\"><i class=\"swatch {}\"></i>{}</button></li>",
                          g, looks[g].colour, escape_markup(looks[g].name));
    }
    page += "</ul><div class=\"scroll\">" + bar_chart_svg(chart, SvgUse::in_page) + "</div></div></section>\n";
  }

  void operator()(const ReportTable& table) const {
    page += "<section>" + heading(table.title, table.note) +
            (table.prose ? "<div class=\"scroll\"><table class=\"figures-table prose\">"
                         : "<div class=\"scroll\"><table class=\"figures-table\">") +
            "<thead><tr><th scope=\"col\">" + escape_markup(table.row_header) + "</th>";
    for (const TableColumn& c : table.columns) {
      page += "<th scope=\"col\">" + escape_markup(c.name);
      if (!c.unit.empty()) page += "<span class=\"unit\">" + escape_markup(c.unit) + "</span>";
      page += "</th>";
    }
    page += "</tr></thead><tbody>\n";
    const std::vector<std::string> best = lowest_texts(table);
    for (const TableRow& row : table.rows) {
      const char* kind = row.role == SeriesRole::main        ? " class=\"ours\""
                         : row.role == SeriesRole::reference ? " class=\"apart\""
                                                             : "";
      page += fmt::format("<tr{}><th scope=\"row\">{}</th>", kind, escape_markup(row.name));
      for (std::size_t c = 0; c < row.cells.size(); ++c) {
        const TableCell& cell = row.cells[c];
        if (!cell.value) {
          // Where the page is narrow each cell stands on a line of its own and says what it is.
          const std::string name =
              table.prose ? " data-name=\"" + escape_markup(table.columns[c].name) + "\"" : std::string();
          page += fmt::format("<td class=\"text\"{}>{}</td>", name, cell.text.empty() ? "–" : escape_markup(cell.text));
          continue;
        }
        const int decimals = table.columns[c].decimals;
        const std::string text = number_text(*cell.value, decimals);
        const bool wins = row.competes && text == best[c];
        page += fmt::format("<td>{}{}{}", wins ? "<b>" : "", text, wins ? "</b>" : "");
        if (cell.spread) page += "<span class=\"pm\"> ± " + number_text(*cell.spread, decimals) + "</span>";
        page += "</td>";
      }
      page += "</tr>\n";
    }
    page += "</tbody></table></div></section>\n";
  }

  void operator()(const ReportNote& note) const {
    page += "<section>" + heading(note.title, "");
    for (const std::string& p : note.paragraphs) page += "<p>" + escape_markup(p) + "</p>\n";
    page += "</section>\n";
  }

  void operator()(const PictureRow& pictures) const {
    page += "<section>" + heading(pictures.title, pictures.note) + "<div class=\"pictures\">";
    for (const std::string& svg : pictures.svg) page += "<figure>" + svg + "</figure>";
    page += "</div></section>\n";
  }

  /// The printed form of each column's least value, so that ties in print are marked alike.
  static std::vector<std::string> lowest_texts(const ReportTable& table) {
    std::vector<std::string> best(table.columns.size());
    for (std::size_t c = 0; c < best.size(); ++c) {
      if (!table.columns[c].mark_lowest) continue;
      std::optional<double> least;
      for (const TableRow& row : table.rows) {
        const std::optional<double>& v = row.cells[c].value;
        if (!row.competes || !v || !std::isfinite(*v)) continue;
        if (!least || *v < *least) least = v;
      }
      if (least) best[c] = number_text(*least, table.columns[c].decimals);
    }
    return best;
  }
};

/// A number never stands at the end of a line without its unit.
std::string keep_units(std::string text) {
  for (const std::string unit : {" °C", " K", " kWh", " %"}) {
    for (std::size_t at = text.find(unit); at != std::string::npos; at = text.find(unit, at + 1)) {
      const std::size_t end = at + unit.size();
      const bool whole = end == text.size() || std::isalnum(static_cast<unsigned char>(text[end])) == 0;
      if (whole && at > 0 && std::isdigit(static_cast<unsigned char>(text[at - 1])) != 0) text.replace(at, 1, "&nbsp;");
    }
  }
  return text;
}

void append_head(std::string& page, const ReportInput& input) {
  // The policy makes "no request leaves this page" a rule of the browser, not a promise.
  page +=
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
      "style-src 'unsafe-inline'; img-src data:\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>" +
      escape_markup(input.title) + "</title>\n<!-- The charts are drawn by uPlot.\n";
  append(page, uplot_licence);
  page += "-->\n<style>\n";
  append(page, uplot_css);
  append(page, palette_css);
  append(page, page_css);
  page += "</style>\n</head>\n<body>\n<header>\n";
  if (!input.subtitle.empty()) page += "<p class=\"kicker\">" + escape_markup(input.subtitle) + "</p>\n";
  page += "<h1>" + escape_markup(input.title) + "</h1>\n";
  if (!input.headline.empty()) page += "<p class=\"headline\">" + keep_units(escape_markup(input.headline)) + "</p>\n";
  if (!input.figures.empty()) {
    page += "<dl class=\"figures\">\n";
    for (const KeyFigure& f : input.figures) {
      page += "<div><dt>" + escape_markup(f.label) + "</dt><dd><strong>" + escape_markup(f.value) +
              "</strong> <span class=\"unit\">" + escape_markup(f.unit) + "</span>";
      if (!f.note.empty()) page += "<small>" + escape_markup(f.note) + "</small>";
      page += "</dd></div>\n";
    }
    page += "</dl>\n";
  }
  page += "</header>\n";
}

}  // namespace

std::string report_html(const ReportInput& input, const ReportOptions& options) {
  for (const ReportBlock& block : input.blocks) std::visit([](const auto& b) { check(b); }, block);
  std::string page;
  page.reserve(1 << 20);
  append_head(page, input);
  page +=
      "<main>\n<noscript><p class=\"note\">The line charts need JavaScript, which is switched off here. The same "
      "charts lie beside this page as SVG files.</p></noscript>\n<nav id=\"days\" hidden></nav>\n";
  json charts = json::array();
  for (const ReportBlock& block : input.blocks) std::visit(BlockWriter{page, charts, options.points_per_chart}, block);

  page += "<section class=\"facts\"><h2>How to repeat this run</h2>\n";
  if (!input.command.empty()) page += "<pre><code>" + escape_markup(input.command) + "</code></pre>\n";
  page += "<dl>\n";
  for (const ReportFact& f : input.facts) {
    page += "<div><dt>" + escape_markup(f.name) + "</dt><dd>" + escape_markup(f.value) + "</dd></div>\n";
  }
  page += "</dl></section>\n</main>\n<script type=\"application/json\" id=\"charts\">" +
          escape_script_json(charts.dump(-1, ' ', false, json::error_handler_t::replace)) + "</script>\n<script>\n";
  append(page, uplot_js);
  page += '\n';
  append(page, chart_parts_js);
  append(page, page_js);
  return page + "</script>\n</body>\n</html>\n";
}

namespace {

/// `shown`: the name by which the reader will know the file.
void write_staged(const std::filesystem::path& path, const std::filesystem::path& shown, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (file) return;
  throw hal::InputError(shown.string(), "a file that cannot be written", "a writable place with free space",
                        "choose another output folder");
}

}  // namespace

std::vector<std::filesystem::path> write_report(const std::filesystem::path& path, const ReportInput& input,
                                                const ReportOptions& options) {
  const std::string page = report_html(input, options);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  hal::StagedFolder staged(folder);
  std::vector<std::filesystem::path> written = {path};
  if (options.svg_files) {
    int number = 0;
    for (const ReportBlock& block : input.blocks) {
      std::string title, svg;
      if (const auto* line = std::get_if<LineChart>(&block)) {
        title = line->title;
        svg = line_chart_svg(downsample(*line, options.points_per_chart));
      } else if (const auto* bars = std::get_if<BarChart>(&block)) {
        title = bars->title;
        svg = bar_chart_svg(*bars);
      } else {
        continue;
      }
      const std::string name = fmt::format("{:02}-{}.svg", ++number, slug(title));
      written.push_back(folder / name);
      write_staged(staged.path() / name, written.back(), svg);
    }
  }
  write_staged(staged.path() / path.filename(), path, page);
  staged.commit(path.filename());
  return written;
}

}  // namespace airside::tools
