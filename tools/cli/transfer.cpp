// airside transfer: a source room's weights, made to fit another room from a few days of its log.

#include <fmt/format.h>

#include <cmath>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "tools/cli/command.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/blob_place.hpp"
#include "tools/run/training/transfer.hpp"

namespace airside::tools {

namespace {

struct TransferCommand {
  SiteOptions site;
  std::string from, log, out = "transferred.blob";
  FineTuneOptions options;
  bool json = false;

  void run() {
    const Site s = make_site(site);
    BlobPlace place(out, most_blob_bytes(s));
    const BlobBytes source = from.empty() ? BlobBytes{} : read_blob(from, s);
    const hal::Log rows = hal::read_log(log, s.counts);
    constexpr std::size_t day_rows = 86400 / row_s;
    if (rows.rows.size() < day_rows) {
      throw hal::InputError(log, fmt::format("{} rows, less than a day", rows.rows.size()),
                            fmt::format("at least {} rows, one day; five days are better", day_rows),
                            "let the schedule run longer and export that log");
    }
    Progress bar(from.empty() ? "training from scratch" : "fine-tuning", progress_steps);
    options.provenance = fmt::format("airside transfer{} --log {} --steps {} --seed {}{}{}",
                                     from.empty() ? "" : " --from " + hal::shell_word(from), hal::shell_word(log),
                                     options.steps, options.seed, command_text(site),
                                     from.empty() ? "" : fmt::format(" (source digest {})", digest_text(source)));
    const Transferred made = transfer(s, source, rows.rows, options, show_progress(bar));
    const BlobBytes& blob = made.blob;
    bar.finish();
    place.write(blob);
    if (json) {
      nlohmann::json j = {{"blob", out},
                          {"blob_bytes", blob.size()},
                          {"digest", digest_text(blob)},
                          {"source_digest", from.empty() ? "" : digest_text(source)},
                          {"rows", rows.rows.size()},
                          {"missing_rows", rows.summary.missing_rows},
                          {"steps", options.steps},
                          {"source_kept", made.source_kept},
                          {"source_error_k", made.source_error_k},
                          {"tuned_error_k", made.tuned_error_k},
                          {"seeds", {options.seed}}};
      add_program_to(j);
      fmt::print("{}\n", j.dump());
      return;
    }
    fmt::print("{} rows from {} to {}; weights: {} ({} bytes, digest {})\n", rows.rows.size(),
               hal::civil_text(rows.summary.first), hal::civil_text(rows.summary.last), out, blob.size(),
               digest_text(blob));
    if (std::isfinite(made.tuned_error_k)) {
      fmt::print(
          "forecasts of the held-back rows err by {:.3f} K fine-tuned, by {:.3f} K with the source as it is: {}\n",
          made.tuned_error_k, made.source_error_k, made.source_kept ? "the source is kept" : "fine-tuned on all rows");
    }
    if (!rows.summary.gaps.empty()) {
      fmt::print("the log has {} gaps ({} rows missing); learning skipped them\n", rows.summary.gaps.size(),
                 rows.summary.missing_rows);
    }
    fmt::print("by {}\n", program_text());
  }
};

}  // namespace

void add_transfer(CLI::App& app) {
  auto self = std::make_shared<TransferCommand>();
  CLI::App* c = app.add_subcommand(
      "transfer",
      "fit a source room's weights to another room's log.\n"
      "The last day of the log (its last third, if it has less than three days) is held back first:\n"
      "where the source predicts it better than fine-tuned weights do, it is kept as it is.");
  add_site_options(*c, self->site);
  c->add_option("--from", self->from, "source blob (none: train from scratch)");
  c->add_option("--log", self->log, "CSV log of the target room under the schedule, 5 days or so")->required();
  c->add_option("--steps", self->options.steps, "optimiser steps")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("--seed", self->options.seed, "of sampling")->check(seed_check())->capture_default_str();
  c->add_option("-o,--out", self->out, "blob to write")->capture_default_str();
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
