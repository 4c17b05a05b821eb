#include "tools/gap/surrogate/asked_model.hpp"

#include "tools/gap/surrogate/analyse_dear.hpp"

namespace airside::tools::gap {

AskedModel::AskedModel(const Engine& model, std::function<void()> replayed, std::function<void()> ran)
    : counted_(model, model.stand_in() ? std::move(ran) : replayed), model_(counted_) {
  const std::optional<sim::RcRoom> room = model.stand_in();
  if (!room) return;
  surrogate_ = std::make_unique<SurrogateEngine>(model_, *room);
  answering_.emplace(*surrogate_, std::move(replayed));
}

WindowResponses AskedModel::responses(const Library& library, const CaseData& data, int jobs) const {
  return {
      data.has_reference() ? simulate_responses(engine(), library, data.reference.recording, true, jobs) : Responses{},
      simulate_responses(engine(), library, data.test.recording, true, jobs)};
}

Verdict AskedModel::analyse(const CaseData& data, WindowResponses& responses, const Rules& rules, int jobs,
                            const std::function<void(const Outlook&)>& look,
                            const std::function<void(const Analysed&)>& judged) {
  if (surrogate_) return analyse_dear(*surrogate_, engine(), data, responses, rules, jobs, look, judged);
  return gap::analyse(engine(), data, responses, rules, jobs, look, judged);
}

}  // namespace airside::tools::gap
