#include "tools/cli/command.hpp"
#include "hal/text/shell_word.hpp"

#include <fmt/format.h>

#include "airside/crc32c.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools {

CLI::Validator a_topology() {
  const auto look = [](const std::string& name) -> std::string {
    if (hal::site_rules().holds(name)) return "";
    return "'" + name +
           "': expected counts of 1 to 32 VAV boxes, 0 to 32 fan coil units and 0 to 8 power meters, such as "
           "5vav-5fcu-2power";
  };
  return {look, "COUNTS", "topology"};
}

void add_site_options(CLI::App& command, SiteOptions& options) {
  command.add_option("--site", options.path, "site file (default: a built-in one)");
  command.add_option("--preset", options.preset, "product, paper or paper-repaired, instead of the site's")
      ->check(CLI::IsMember(hal::preset_names()));
  command.add_option("--topology", options.topology, "of the built-in site")
      ->check(a_topology())
      ->capture_default_str();
}

Site make_site(const SiteOptions& options) {
  if (!options.path.empty() && options.topology != SiteOptions{}.topology) {
    throw hal::InputError("--topology " + options.topology, "--site " + options.path + " beside it",
                          "one of the two: a site file has a topology of its own", "leave one of them out");
  }
  Site site = options.path.empty() ? built_in_site(options.topology) : load_site(options.path);
  if (!options.preset.empty()) {
    site = with_preset(site, hal::preset_named(options.preset));
  }
  return site;
}

std::string command_text(const SiteOptions& options) {
  std::string text;
  if (!options.path.empty()) text += " --site " + hal::shell_word(options.path);
  if (!options.preset.empty()) text += " --preset " + options.preset;
  if (options.path.empty() && options.topology != SiteOptions{}.topology) text += " --topology " + options.topology;
  return text;
}

OnProgress show_progress(Progress& bar) {
  return [&bar](double share) { bar.set(static_cast<std::uint64_t>(share * progress_steps)); };
}

/// Of energy: a run without a meter has none, which is not nothing used.
nlohmann::json measured(double kwh) { return kwh > 0 ? nlohmann::json(kwh) : nlohmann::json(); }

nlohmann::json json_of(const Metrics& m) {
  nlohmann::json days = nlohmann::json::array(), worst = nlohmann::json::array();
  for (const DayMetrics& d : m.days) {
    days.push_back(d.dae_degc);
    worst.push_back(d.worst_room_dae_degc);
  }
  return {{"dae_degc", m.dae_degc},
          {"me_degc", m.me_degc},
          {"day1_dae_degc", m.day1_dae_degc},
          {"darv_degc", m.darv_degc},
          {"darv_full_day_degc", m.darv_full_day_degc},
          {"cdh_degch", m.cdh_degch},
          {"hdh_degch", m.hdh_degch},
          {"degree_hours_per_day_degch", m.degree_hours_degch},
          {"degree_hours_above_per_day_degch", m.degree_hours_above_degch},
          {"hvac_kwh", measured(m.hvac_kwh)},
          {"hvac_kwh_per_day", measured(m.hvac_kwh_per_day)},
          {"saved_area_per_day_degch", m.saved_area_degch},
          {"room_dae_degc", m.room_dae_degc},
          {"rooms_dae_degc", m.rooms_dae_degc},
          {"worst_room_dae_degc", m.worst_room_dae_degc},
          {"daily_worst_room_dae_degc", worst},
          {"daily_dae_degc", days}};
}

void print_figures_header() {
  fmt::print("{:<26} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>10} {:>9}\n", "method", "DAE", "ME", "day 1", "DARV", "CDH",
             "HDH", "deg-h/day", "kWh/day");
}

void print_figures(const std::string& name, const Metrics& m) {
  const std::string energy = m.hvac_kwh > 0 ? fmt::format("{:.1f}", m.hvac_kwh_per_day) : "-";
  fmt::print("{:<26} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>9.1f} {:>9.1f} {:>10.2f} {:>9}\n", name, m.dae_degc,
             m.me_degc, m.day1_dae_degc, m.darv_degc, m.cdh_degch, m.hdh_degch, m.degree_hours_degch, energy);
}

std::string digest_text(const BlobBytes& blob) { return fmt::format("{:08x}", crc32c(blob)); }

}  // namespace airside::tools
