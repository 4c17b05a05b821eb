// airside gap bills: what monthly bills alone tell of a model.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_folder.hpp"
#include "sim/weather/epw.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/gap/gap.hpp"
#include "tools/gap/bills/bill_picture.hpp"
#include "tools/gap/bills/bill_text.hpp"
#include "tools/gap/case/case_format.hpp"
#include "tools/gap/map/mapped_model.hpp"
#include "tools/gap/model/energyplus_engine.hpp"
#include "tools/gap/model/patched_model.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct BillsCommand : GapOptions {
  std::string map, bills, reference, out = "gap-bills", cache;
  gap::BillPriors priors;

  /// Meters' columns of the mapping, by their places among the powers.
  static std::vector<std::string> meters_of(const gap::Mapping& mapping) {
    if (!mapping.commands.empty()) {
      throw hal::InputError(mapping.commands.front().place, "a command", "none: bills record no commands",
                            "write a mapping without [[command]] for bills");
    }
    std::vector<std::string> names;
    for (const gap::MappedChannel* channel : mapping.of(gap::MappedKind::power)) names.push_back(channel->column);
    if (names.empty()) {
      throw hal::InputError(mapping.path, "no channel of kind power", "a [[channel]] with a meter for each bill",
                            "add the meters");
    }
    return names;
  }

  std::unique_ptr<gap::Engine> engine_of(const gap::Mapping& mapping, const fs::path& prepared) const {
    gap::CaseDescription c;
    c.engine = "energyplus";
    c.map = map;
    c.model = gap::prepare_mapped_model(mapping, prepared).string();
    c.weather = mapping.weather;
    c.topology = gap::counts_of(mapping).name;
    return std::make_unique<gap::EnergyPlusEngine>(sim::twin_of(gap::energyplus_options_of(c)),
                                                   fs::path(mapping.model).filename().string(), cache, false);
  }

  /// What sensors alone show is in no bill.
  static gap::Library library_of(const gap::Engine& engine, const std::vector<sim::Effect>& list) {
    gap::Library library = gap::library_of(engine, list);
    std::erase_if(library.candidates, [&](const sim::EffectAt& at) { return engine.only_shows(*at.effect); });
    std::erase_if(library.parameters, [&](const sim::EffectAt& at) { return engine.only_shows(*at.effect); });
    return library;
  }

  void run() const {
    require_writable("--out", out, true);
    const gap::Mapping mapping = gap::read_mapping(map);
    const std::vector<std::string> known = meters_of(mapping);
    const gap::BillTable table = gap::read_bills(bills, known);
    std::optional<gap::BillTable> before;
    if (!reference.empty()) {
      before = gap::read_bills(reference, known);
      if (before->meters != table.meters) {
        throw hal::InputError(reference, fmt::format("the meters {}", fmt::join(before->meters, ", ")),
                              fmt::format("those of {}: {}", bills, fmt::join(table.meters, ", ")),
                              "give bills of the same meters");
      }
    }
    std::vector<int> meters;
    for (const std::string& meter : table.meters)
      meters.push_back(static_cast<int>(std::find(known.begin(), known.end(), meter) - known.begin()));
    const auto list = effects();
    const auto station = sim::read_epw(mapping.weather, {.whole_year = false, .from = {}, .to = {}});
    hal::StagedFolder folder(out);
    const auto engine = engine_of(mapping, folder.path() / "model");
    const gap::Library library = library_of(*engine, list);
    gap::Library parameters = library;
    parameters.candidates.clear();
    Progress bar("bills against " + engine->description(),
                 gap::bill_runs(library, table) + (before ? gap::bill_runs(parameters, *before) : 0));
    const auto responses = [&](const gap::Library& asked, const gap::BillTable& of) {
      return gap::bill_responses(*engine, asked, of, meters, station, jobs, [&bar] { bar.advance(); });
    };
    const gap::BillResponses measured = responses(library, table);
    const gap::BillResponses earlier = before ? responses(parameters, *before) : gap::BillResponses{};
    bar.finish();
    const gap::BillEvidence shown{table, measured}, known_before{before ? *before : table, earlier};
    const gap::BillVerdict verdict = gap::judge_bills(shown, before ? &known_before : nullptr, priors);
    const nlohmann::json j = gap::json_of(verdict, table);
    gap::write_whole_file(folder.path() / "bills.json", j.dump(1) + "\n");
    gap::write_whole_file(folder.path() / "bills.svg", gap::bills_svg(table, verdict));
    fs::remove_all(folder.path() / "model");
    folder.commit("bills.json");
    if (json) {
      fmt::print("{}\n", j.dump());
    } else {
      fmt::print("{}", gap::text_of(verdict));
      fmt::print("\npicture: {}\n", (fs::path(out) / "bills.svg").string());
    }
  }
};

}  // namespace

void add_gap_bills(CLI::App& gap) {
  auto self = std::make_shared<BillsCommand>();
  CLI::App* c = gap.add_subcommand(
      "bills", "what monthly bills alone tell of a model: which effect is missing, and what they could show at all");
  c->add_option("bills", self->bills, "CSV file: from, to (dates), and kWh of each meter by its column's name")
      ->required();
  c->add_option("--map", self->map, "mapping file: the model, its weather, and a channel of kind power for each meter")
      ->required();
  c->add_option("--reference", self->reference, "bills of a time in which nothing was missing, of the same meters");
  c->add_option("--level", self->priors.level, "how far a meter may be off in all bills, as a share (a stated prior)")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  c->add_option("--period", self->priors.period, "and each bill by itself: people, weather, reading dates")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  c->add_option("-o,--out", self->out, "folder for bills.json and bills.svg")->capture_default_str();
  c->add_option("--cache", self->cache, "folder of finished EnergyPlus runs, used again");
  self->add_effects(*c);
  self->add_jobs(*c);
  self->add_json(*c);
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
