#include "tools/cli/blob/rank.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"
#include "hal/weights/signature.hpp"
#include "tools/cli/command.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/blob_place.hpp"
#include "tools/run/training/transfer.hpp"

namespace airside::tools {

namespace {

struct Source {
  std::string path, digest;
  double error_k = 0;
  std::string refusal;  ///< why it cannot serve this room; empty: it can
};

struct RankCommand {
  SiteOptions site;
  std::vector<std::string> blobs;
  std::string log;
  bool json = false;

  /// A blob of another shape is no mistake in a library of many rooms; a file that cannot be read is.
  Source judged(const Site& s, const std::string& path, const hal::Log& rows) const {
    Source out{.path = path, .digest = {}, .error_k = 0, .refusal = {}};
    (void)hal::sound_header(hal::read_blob_file(path), path);
    try {
      const BlobBytes bytes = read_blob(path, s);
      out.digest = digest_text(bytes);
      out.error_k = forecast_error_k(s, bytes, rows.rows);
      if (!std::isfinite(out.error_k)) out.refusal = path + ": no forecast could be compared: it has no room head";
    } catch (const hal::InputError& error) {
      out.refusal = error.what();
    }
    return out;
  }

  void run() const {
    const Site s = make_site(site);
    const hal::Log rows = hal::read_log(log, s.counts);
    std::vector<Source> sources;
    Progress bar("blobs", blobs.size());
    for (const std::string& path : blobs) {
      sources.push_back(judged(s, path, rows));
      bar.advance();
    }
    bar.finish();
    const auto serves = [](const Source& a) { return a.refusal.empty(); };
    std::stable_partition(sources.begin(), sources.end(), serves);
    const auto refused = std::find_if_not(sources.begin(), sources.end(), serves);
    std::stable_sort(sources.begin(), refused, [](const Source& a, const Source& b) { return a.error_k < b.error_k; });
    if (json) {
      print_json(sources, rows);
    } else {
      print(sources, rows);
    }
    if (refused == sources.begin()) {
      throw hal::InputError("blob rank", "no blob that fits this site", "at least one",
                            "give blobs of rooms with the same counts, cycle and signals");
    }
  }

  void print_json(const std::vector<Source>& sources, const hal::Log& rows) const {
    nlohmann::json ranked = nlohmann::json::array();
    for (const Source& source : sources) {
      nlohmann::json one = {{"blob", source.path}, {"digest", source.digest}};
      if (source.refusal.empty()) {
        one["forecast_error_k"] = source.error_k;
      } else {
        one["refused"] = source.refusal;
      }
      ranked.push_back(one);
    }
    nlohmann::json j = {{"log", log}, {"rows", rows.rows.size()}, {"sources", ranked}};
    add_program_to(j);
    fmt::print("{}\n", j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }

  void print(const std::vector<Source>& sources, const hal::Log& rows) const {
    fmt::print("{} rows of {}; error of the room head's forecasts one cycle ahead, best first\n\n", rows.rows.size(),
               log);
    for (const Source& source : sources) {
      if (source.refusal.empty()) {
        fmt::print("  {:.4f} K  {}  {}\n", source.error_k, source.digest, source.path);
      } else {
        fmt::print("  refused   {}\n", source.refusal);
      }
    }
  }
};

}  // namespace

void add_rank(CLI::App& blob) {
  auto self = std::make_shared<RankCommand>();
  CLI::App* c = blob.add_subcommand("rank",
                                    "order several rooms' weights by how well they foretell a room's log, best first:\n"
                                    "the first is the source for airside transfer --from");
  add_site_options(*c, self->site);
  c->add_option("blobs", self->blobs, "blobs to compare")->required();
  c->add_option("--log", self->log, "CSV log of the room, a day or more")->required();
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
