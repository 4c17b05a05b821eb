#pragma once
// The subcommands of `airside`: each file adds one, with its options and what it does.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tools/run/control_run.hpp"
#include "tools/run/metrics.hpp"
#include "tools/run/progress/progress.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

void add_chaos(CLI::App& app);
void add_adopt(CLI::App& app);
void add_check(CLI::App& app);
void add_init(CLI::App& app);
struct DoctorFinding;  // tools/cli/site/doctor.hpp
/// Adds what it finds on this machine beyond what a box needs.
using LookAtHost = void (*)(std::vector<DoctorFinding>& out);
void look_at_host(std::vector<DoctorFinding>& out);
/// `look_at_host`: none on the box.
void add_doctor(CLI::App& app, LookAtHost look_at_host = nullptr);
void add_tags(CLI::App& app);
void add_pretrain(CLI::App& app);
void add_residual(CLI::App& app);
void add_transfer(CLI::App& app);
void add_simulate(CLI::App& app);
void add_serve(CLI::App& app);
void add_study(CLI::App& app);
void add_campaign(CLI::App& app);
void add_weight_library(CLI::App& app);
void add_fleet(CLI::App& app);
void add_blob(CLI::App& app);
void add_report(CLI::App& app);
void add_footprint(CLI::App& app);
void add_status(CLI::App& app);
/// What `airside status` prints of a status.json, a state folder or a site file.
/// Errors: hal::InputError for a status that cannot be read.
std::string status_sentences(const std::string& path);
void add_watch(CLI::App& app);
void add_probe(CLI::App& app);
void add_gap(CLI::App& app);
void add_pull(CLI::App& app);
/// Hidden: prints shell completion of all commands that were added before it.
void add_completion(CLI::App& app);

/// Of a box's page: PEM certificates to trust, and a file with the key that `airside-page --new-key` printed; "": none.
struct BoxAccess {
  std::string ca, key_file;
};
/// Sends a blob to a web address; returns what is to be reported of it.
using SendBlob = nlohmann::json (*)(const std::string& address, std::span<const std::byte> blob,
                                    const BoxAccess& access);
nlohmann::json send_over_http(const std::string& address, std::span<const std::byte> blob, const BoxAccess& access);
/// `over_http`: none on the box, which has its inbox at hand.
void add_weights(CLI::App& app, SendBlob over_http = nullptr);

/// --site, --preset and --topology, shared by all commands on a room.
struct SiteOptions {
  std::string path;                           ///< empty: the built-in site
  std::string preset;                         ///< empty: the site's
  std::string topology = "5vav-5fcu-2power";  ///< of the built-in site
};
void add_site_options(CLI::App& command, SiteOptions& options);
/// For options that take a topology: refuses counts that this build cannot hold.
CLI::Validator a_topology();
/// Errors: hal::InputError.
Site make_site(const SiteOptions& options);

/// The site options as they must be typed again, each after a space; "" for the built-in site as it is.
std::string command_text(const SiteOptions& options);

/// Progress to standard error as a share of the work; pass on to control runs.
OnProgress show_progress(Progress& bar);
constexpr std::uint64_t progress_steps = 1000;

/// The figures of a run, units in the names: dae_degc, me_degc, darv_degc, cdh_degch, hdh_degch, hvac_kwh, ...
nlohmann::json json_of(const Metrics& metrics);

/// One line of a table on standard output: name and the usual figures.
void print_figures(const std::string& name, const Metrics& metrics);
void print_figures_header();

/// CRC-32C of a blob as eight hex digits, its short name in reports.
std::string digest_text(const BlobBytes& blob);

}  // namespace airside::tools
