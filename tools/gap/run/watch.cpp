#include "tools/gap/run/watch.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "tools/gap/surrogate/asked_model.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/run/site.hpp"

namespace airside::tools::gap {

namespace {

/// What all nights share.
class NightJudge {
 public:
  NightJudge(const GapRequest& request, const std::vector<sim::Effect>& effects)
      : jobs_(request.jobs),
        source_(request.source),
        loaded_(load_case(request.source, request.site, request.cache)),
        asked_(*loaded_.engine),
        buildings_(request.buildings.value_or(asked_.engine().usual_buildings())),
        library_(library_of(asked_.engine(), effects)),
        reference_(loaded_.data.has_reference() ? responses_in(loaded_.data.reference) : Responses{}) {}

  const LoadedCase& loaded() const { return loaded_; }

  Night judge(const CleanLog& log, CivilTime from, CivilTime end) {
    Night night{end, "refused", "", "", false};
    std::vector<hal::LogRow> rows;
    for (const hal::LogRow& row : log.rows) {
      if (!(row.time < from) && row.time < end) rows.push_back(row);
    }
    try {
      CaseData data = loaded_.data;
      data.test = window_of_log(source_, rows, loaded_.engine->channels(), loaded_.data.test.recording.station,
                                log.place, loaded_.counts);
      Rules rules;
      rules.buildings = buildings_;
      WindowResponses responses{reference_, responses_in(data.test)};
      const Verdict verdict = asked_.analyse(data, responses, rules, jobs_);
      night.verdict = text_of(verdict.kind);
      if (!verdict.findings.empty()) night.effect = verdict.findings.front().at.id();
      night.sentence = sentence_of(verdict);
    } catch (const hal::InputError& reason) {
      night.sentence = reason.what();
    }
    return night;
  }

 private:
  Responses responses_in(const Window& window) const {
    return simulate_responses(asked_.engine(), library_, window.recording, true, jobs_);
  }

  int jobs_;
  CaseDescription source_;
  LoadedCase loaded_;
  AskedModel asked_;
  int buildings_;
  Library library_;
  Responses reference_;
};

std::int64_t midnight_s(std::int64_t seconds) { return seconds / seconds_per_day * seconds_per_day; }

}  // namespace

void set_alarms(std::vector<Night>& nights, int stands) {
  int same = 0;
  for (std::size_t i = 0; i < nights.size(); ++i) {
    const bool named = nights[i].verdict == text_of(VerdictKind::named);
    const bool as_before = i > 0 && same > 0 && nights[i].effect == nights[i - 1].effect &&
                           nights[i].end.seconds - nights[i - 1].end.seconds == seconds_per_day;
    same = !named ? 0 : as_before ? same + 1 : 1;
    nights[i].alarm = same >= stands;
  }
}

std::vector<Night> judge_nights(const GapRequest& request, const std::string& logs,
                                const std::vector<sim::Effect>& effects, const WatchRules& rules,
                                const std::function<void()>& done) {
  NightJudge judge(request, effects);
  CleanUpContext context;
  context.counts = judge.loaded().counts;
  context.station = judge.loaded().data.test.recording.station;
  CleanLog log = read_log_of(request.source, logs, context);
  const CaseLogs& known = judge.loaded().logs;
  same_room(known.reference.rows.empty() ? known.measured : known.reference, log, context);
  log.require_usable();
  fmt::print(stderr, "{}", warnings_text(log));
  const std::int64_t last = midnight_s(log.rows.back().time.seconds + row_s), length = rules.days * seconds_per_day;
  if (log.rows.front().time.seconds > last - length) {
    throw hal::InputError(logs,
                          fmt::format("rows from {} to {}", hal::civil_text(log.rows.front().time),
                                      hal::civil_text(log.rows.back().time)),
                          fmt::format("{} whole days at least", rules.days), "wait, or give a smaller --days");
  }
  std::vector<Night> nights;
  for (int back = rules.nights - 1; back >= 0; --back) {
    const CivilTime end{last - back * seconds_per_day}, from{end.seconds - length};
    if (from < log.rows.front().time) continue;
    nights.push_back(judge.judge(log, from, end));
    if (done) done();
  }
  set_alarms(nights, rules.stands);
  return nights;
}

nlohmann::json json_of(const Night& n) {
  return {{"end", hal::civil_text(n.end)},
          {"verdict", n.verdict},
          {"effect", n.effect},
          {"sentence", n.sentence},
          {"alarm", n.alarm}};
}

Night night_from(const nlohmann::json& j, const std::string& place) {
  try {
    const std::string end = j.at("end");
    const auto time = hal::parse_civil_text(end);
    if (!time) throw hal::InputError(place, end, "a time such as 2021-07-15T00:00:00", "remove the file");
    return {*time, j.at("verdict"), j.at("effect"), j.at("sentence"), false};
  } catch (const nlohmann::json::exception& e) {
    throw hal::InputError(place, e.what(), "what airside gap watch wrote", "remove the file");
  }
}

}  // namespace airside::tools::gap
