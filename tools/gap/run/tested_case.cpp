#include "tools/gap/run/tested_case.hpp"

#include "tools/gap/case/case_tests.hpp"
#include "tools/gap/model/stretches.hpp"
#include "tools/gap/run/more_days.hpp"
#include "tools/gap/run/proposed_tests.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/gap/verdict/workflow.hpp"

namespace airside::tools::gap {

nlohmann::json judge_with_tests(const std::filesystem::path& folder, const std::vector<sim::Effect>& effects,
                                const std::filesystem::path& cache, int jobs, bool propose,
                                std::optional<int> buildings) {
  const std::string name = folder.filename().string();
  std::vector<std::string> done;
  GapRun run;
  run.request.source = read_case(folder);
  for (const CaseTest& test : read_case_tests(folder)) {
    run.request.more.push_back({(folder / test.log).string(), test.name});
    done.push_back(test.name);
  }
  nlohmann::json judged;
  try {
    run.loaded = load_case(run.request.source, name, cache);
    run.rules.buildings = buildings.value_or(run.loaded.engine->usual_buildings());
    add_more_days(run, effects);
    const StretchedEngine engine(*run.loaded.engine);
    const Library library = library_of(engine, effects);
    const CaseData& data = run.loaded.data;
    const auto responses = [&](const Window& window) {
      return simulate_responses(engine, library, window.recording, true, jobs);
    };
    const WindowResponses all{responses(data.reference), responses(data.test)};
    const Verdict verdict = analyse(engine, data, all, run.rules, jobs);
    judged = json_of(verdict, name, all.test, run.channels(), run.rules);
    if (propose && proposes_tests(verdict))
      judged["experiments"] = proposals_json(proposed_tests(engine, data.test, verdict, all.test, jobs));
  } catch (const RefusedLog& e) {
    judged = refused_json(name, e.what());
  }
  judged["tests"] = done;
  return judged;
}

}  // namespace airside::tools::gap
