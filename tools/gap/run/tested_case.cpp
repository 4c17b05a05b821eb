#include "tools/gap/run/tested_case.hpp"

#include "tools/gap/case/case_tests.hpp"
#include "tools/gap/run/more_days.hpp"
#include "tools/gap/run/proposed_tests.hpp"
#include "tools/gap/surrogate/asked_model.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

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
    AskedModel asked(*run.loaded.engine);
    const Engine& engine = asked.engine();
    run.rules.buildings = buildings.value_or(engine.usual_buildings());
    add_more_days(run, effects);
    const CaseData& data = run.loaded.data;
    WindowResponses all = asked.responses(library_of(engine, effects), data, jobs);
    const Verdict verdict = asked.analyse(data, all, run.rules, jobs);
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
