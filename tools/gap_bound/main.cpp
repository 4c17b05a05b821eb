// airside-gap-bound: draws sealed cases as `airside gap blind` does, and writes what is to be seen in them as tables.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tools/gap/bound/bound_cases.hpp"
#include "tools/gap/case/case_format.hpp"
#include "tools/run/progress/progress.hpp"

namespace airside::tools::gap {

namespace {

struct Command {
  BoundPlan plan;
  std::string folder = "bound", cases, key;

  void run() const {
    if (!cases.empty()) {
      const std::string name = std::filesystem::path(cases).lexically_normal().filename().string();
      Progress bar("tables of cases", case_folders(cases).size());
      make_bound_tables_of(cases, key, folder, name.empty() ? "cases" : name, plan.jobs, [&bar] { bar.advance(); });
      bar.finish();
      return;
    }
    const std::vector<sim::Effect> effects = sim::load_effects(sim::find_effects());
    std::map<bool, Eigen::VectorXd> noise;
    if (!plan.rough) {
      constexpr int rooms = 10;
      Progress bar("noise of rooms", rooms);
      noise = bound_noise(plan, effects, folder, [&bar] { bar.advance(); });
      bar.finish();
    }
    Progress bar("hiding effects in cases", static_cast<std::uint64_t>(plan.drawings * plan.cases));
    const int made = make_bound_tables(plan, noise, effects, folder, [&bar] { bar.advance(); });
    bar.finish();
    fmt::print("{} drawings of {} cases made in {}, {} were there\nnext: tools/learn_bound {}\n", made, plan.cases,
               folder, plan.drawings - made, folder);
  }
};

}  // namespace

}  // namespace airside::tools::gap

int main(int argc, char** argv) {
  airside::tools::gap::Command c;
  CLI::App app{"draws sealed cases of the gap workflow, one hidden effect each, and writes tables to learn from",
               "airside-gap-bound"};
  app.add_option("--seed", c.plan.first_seed, "of the first drawing; each has one more")->capture_default_str();
  app.add_option("--drawings", c.plan.drawings, "how many; those that are there already are left as they are")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--cases", c.plan.cases, "of a drawing")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--room", c.plan.twin, "the workflow's room")->capture_default_str();
  app.add_option("--days", c.plan.days, "of the reference, and again of the measured period")
      ->check(CLI::Range(4, 60))
      ->capture_default_str();
  app.add_option("-j,--jobs", c.plan.jobs, "cores")->check(CLI::Range(1, 256))->capture_default_str();
  app.add_flag("--rough", c.plan.rough, "sizes by a table of noise instead of fits: quick, not exact");
  app.add_option("-o,--out", c.folder, "folder for the tables")->capture_default_str();
  auto* cases = app.add_option("--of", c.cases, "instead of drawing: the cases in this folder, as blind wrote them");
  app.add_option("--key", c.key, "their key")->needs(cases);
  CLI11_PARSE(app, argc, argv);
  try {
    c.run();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "airside-gap-bound: %s\n", e.what());
    return 1;
  }
  return 0;
}
