// airside gap next: more days, or a test on site, after a first verdict.

#include <fmt/format.h>

#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/gap/gap.hpp"
#include "tools/cli/gap/gap_output.hpp"
#include "tools/gap/run/gap_inputs.hpp"
#include "tools/run/log_weather.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct NextCommand : GapOptions {
  std::string earlier, measured, test, out = "gap-next", cache;

  bool is_case() const { return fs::exists(fs::path(earlier) / "case.json"); }

  /// A case was judged by run-cases, which keeps a verdict and no report: it is judged again.
  gap::GapRequest case_request() const {
    gap::GapRequest r;
    r.source = gap::read_case(earlier);
    r.site = fs::path(earlier).filename().string();
    r.effects = effects_folder();
    return r;
  }

  std::string again() const {
    std::string text =
        fmt::format("airside gap next {} --measured {}", hal::shell_word(earlier), hal::shell_word(measured));
    if (!effects_dir.empty()) text += " --effects " + hal::shell_word(effects_dir);
    if (!test.empty()) text += " --test " + hal::shell_word(test);
    return text + " --out " + hal::shell_word(out);
  }

  gap::GapRun judged(const gap::GapRequest& request, const std::vector<sim::Effect>& list) const {
    try {
      StagedProgress progress(stderr);
      return gap::run_gap(request, list, progress);
    } catch (const gap::RefusedLog& e) {
      print_clean_up(stderr, e.logs().reference);
      print_clean_up(stderr, e.logs().measured);
      throw;
    }
  }

  void run() const {
    if (fs::weakly_canonical(out) == fs::weakly_canonical(earlier)) {
      throw hal::InputError("--out " + out, "the folder of the earlier report", "another folder",
                            "the earlier report is kept, so that nothing is lost");
    }
    require_writable("--out", out, true);
    if (!is_case() && !effects_dir.empty()) {
      throw hal::InputError("--effects " + effects_dir, "a report, which says which effects it was made with",
                            "the option for a case alone", "leave it out");
    }
    gap::GapRequest request = is_case() ? case_request() : gap::earlier_request(earlier);
    std::vector<sim::Effect> list = sim::load_effects(request.effects);
    if (request.sun_on_site) list = sim::with_sun_on_site(std::move(list));
    request.command = again();
    request.jobs = jobs;
    request.cache = cache.empty() ? fs::path(out) / "runs" : fs::path(cache);
    if (is_case()) {
      request.earlier = gap::json_of(judged(request, list));
      request.earlier["report"] = earlier;
    }
    request.more.push_back({measured, test});
    const gap::GapRun run = judged(request, list);
    const RunFacts facts = run_facts(request.source.engine == "energyplus", weather_file_text(request.source.weather));
    print_gap(run, write_gap_folder(run, facts, {out, "", false}), facts, json);
  }
};

}  // namespace

void add_gap_next(CLI::App& gap) {
  auto self = std::make_shared<NextCommand>();
  CLI::App* c = gap.add_subcommand(
      "next", "continue an earlier verdict with more days, or with the log of a test on site, and judge anew");
  c->add_option("earlier", self->earlier, "folder of the earlier report, or of a case")->required();
  c->add_option("--measured", self->measured, "log of the further days: a CSV file, or a folder of daily ones")
      ->required();
  c->add_option("--test", self->test,
                "the test that was done in them, by its name in the earlier report (night_purge); the log begins two "
                "days before it");
  c->add_option("-o,--out", self->out, "folder for the report, gap.json and the patch")->capture_default_str();
  c->add_option("--cache", self->cache, "folder of finished EnergyPlus runs (default: OUT/runs)");
  self->add_effects(*c);
  self->add_jobs(*c);
  self->add_json(*c);
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
