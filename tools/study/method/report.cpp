#include "tools/study/method/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "tools/run/run_facts.hpp"
#include "tools/study/method/figures.hpp"
#include "tools/study/method/tables.hpp"

namespace airside::tools {

namespace {

constexpr int seeds_asked_for = 5;

int count_of(const std::vector<ClaimVerdict>& claims, ClaimState state) {
  return static_cast<int>(std::ranges::count(claims, state, &ClaimVerdict::state));
}

std::string headline(const MethodResults& results, const std::vector<ClaimVerdict>& claims) {
  std::string text = fmt::format(
      "Of {} published claims {} are reproduced by these runs, {} in part, {} not; {} wait for runs, {} are measured "
      "elsewhere.",
      claims.size(), count_of(claims, ClaimState::reproduced), count_of(claims, ClaimState::partly),
      count_of(claims, ClaimState::not_reproduced), count_of(claims, ClaimState::not_run),
      count_of(claims, ClaimState::elsewhere));
  if (results.seeds() < seeds_asked_for) {
    text += fmt::format(" The rules of the claims ask for {} seeds; {} here, so the verdicts are provisional.",
                        seeds_asked_for, results.seeds());
  }
  return text;
}

ReportTable claims_table(const std::vector<ClaimVerdict>& claims) {
  ReportTable table;
  table.title = "Claims, one by one";
  table.note =
      "Each by its own rule, from means over rooms and seeds. Sizes cannot be compared with the published "
      "ones, which come from another building; directions can.";
  table.row_header = "claim";
  table.prose = true;
  for (const char* name : {"what is claimed", "published", "verdict", "ours"}) {
    table.columns.emplace_back().name = name;
  }
  const auto text = [](const std::string& t) {
    TableCell cell;
    cell.text = t;
    return cell;
  };
  for (const ClaimVerdict& c : claims) {
    table.rows.push_back({std::to_string(c.number),
                          {text(c.claim), text(c.published), text(text_of(c.state)), text(c.ours)},
                          SeriesRole::plain,
                          false});
  }
  return table;
}

/// A column of the study's tables, whose titles end with the unit: on a page a difference of temperatures is in K.
TableColumn page_column(const nlohmann::json& column) {
  const std::string title = column["title"], degrees = " °C";
  const std::size_t at = title.find(degrees);
  if (at == std::string::npos) return table_column(title, "", column["decimals"], false);
  return table_column(title.substr(0, at), "K" + title.substr(at + degrees.size()), column["decimals"], false);
}

/// A table of the study as one of the page, each column followed by the published figure where there is one.
ReportTable page_table(const nlohmann::json& from, const char* published_as) {
  ReportTable table;
  table.title = from["title"].get<std::string>() + (*published_as == '\0' ? "" : fmt::format(" ({})", published_as));
  table.note = "Mean ± standard deviation over rooms and seeds; beside it what is printed.";
  table.row_header = "run";
  const auto any = [&from](const std::string& key, const char* part) {
    return std::ranges::any_of(from["lines"], [&](const nlohmann::json& l) { return l[part].contains(key); });
  };
  struct Shown {
    std::string key;
    bool published;
  };
  std::vector<Shown> shown;
  for (const nlohmann::json& column : from["columns"]) {
    const std::string key = column["key"];
    if (!any(key, "figures")) continue;
    table.columns.push_back(page_column(column));
    shown.push_back({key, any(key, "published")});
    if (shown.back().published) table.columns.push_back(table_column("published", "", 3, false));
  }
  for (const nlohmann::json& line : from["lines"]) {
    TableRow row{line["line"], {}, SeriesRole::plain, false};
    for (const Shown& s : shown) {
      TableCell cell;
      if (line["figures"].contains(s.key)) {
        const nlohmann::json& f = line["figures"][s.key];
        cell.value = f["mean"].get<double>();
        if (f["count"] > 1) cell.spread = f["sd"].get<double>();
      }
      row.cells.push_back(cell);
      if (!s.published) continue;
      TableCell printed;
      if (line["published"].contains(s.key)) printed.text = fmt::format("{:g}", line["published"][s.key].get<double>());
      row.cells.push_back(printed);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

constexpr auto printed_as =
    std::to_array<std::pair<const char*, const char*>>({{"control", "printed figure 7"},
                                                        {"score", "printed table IV"},
                                                        {"ablation", "printed table V"},
                                                        {"pretraining", "printed figure 9"},
                                                        {"deployment", "printed figures 11, 12"},
                                                        {"neighbours", "printed figure 13"},
                                                        {"offline", "printed table VI"},
                                                        {"cycle", "printed figure 10"}});

const char* published_place(const std::string& table) {
  const auto found = std::ranges::find(printed_as, table, [](const auto& p) { return std::string(p.first); });
  return found == printed_as.end() ? "" : found->second;
}

/// Tables first those of the publication in its order, a figure beside the table that it belongs to.
void add_blocks(ReportInput& page, const MethodResults& results, const PeerRows& peers) {
  std::map<std::string, nlohmann::json> tables;
  for (const nlohmann::json& table : method_tables_of(results)) tables.emplace(table["table"], table);
  const auto add_table = [&](const char* name) {
    if (tables.contains(name)) page.blocks.emplace_back(page_table(tables[name], published_place(name)));
  };
  const auto add = [&page](std::optional<ReportBlock> block) {
    if (block) page.blocks.push_back(std::move(*block));
  };
  add(figure_of_days(results, peers));
  add(figure_of_two_weeks(results, peers));
  add_table("control");
  add(peers_table(peers));
  add(transfer_table(peers));
  add_table("score");
  add_table("ablation");
  add_table("physics");
  add(figure_of_pretraining(results));
  add_table("pretraining");
  add(figure_of_cycles(results));
  add_table("cycle");
  add(figure_of_saved_area(results));
  add(figure_of_transfer(results, "701-real"));
  add(figure_of_transfer(results, "702-real"));
  add_table("deployment");
  add_table("data");
  add(figure_of_neighbours(results, "401-real"));
  add(figure_of_neighbours(results, "402-real"));
  add_table("neighbours");
  add_table("offline");
}

}  // namespace

ReportInput method_report(const MethodStudy& study, const MethodResults& results, const PeerRows& peers,
                          const std::vector<ClaimVerdict>& claims, const std::string& command) {
  ReportInput page;
  page.title = "The published method, tried again";
  page.subtitle = fmt::format(
      "{} runs of {} seed{} on {}", results.runs(), results.seeds(), results.seeds() == 1 ? "" : "s",
      study.environment.empty() ? (study.kind == "rc" ? "the RC plant" : "EnergyPlus") : "a learned environment");
  page.headline = headline(results, claims);
  page.blocks.emplace_back(claims_table(claims));
  add_blocks(page, results, peers);
  if (peers.empty()) {
    page.blocks.emplace_back(ReportNote{
        "What these runs lack",
        {"OSLN, DDQN, LSTM, Transformer, FATDM and DAF are made by tools/gym/method_peers; --peers shows them here."}});
  }
  page.facts = {{"runs", study.folder}, {"program", program_text()}};
  const nlohmann::json facts = study.facts();
  for (const auto& [name, value] : facts.items()) {
    page.facts.push_back({name, value.is_string() ? value.get<std::string>() : value.dump()});
  }
  page.command = command;
  return page;
}

}  // namespace airside::tools
