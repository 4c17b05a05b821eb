#pragma once
// Who answers the questions about a case: its model, or an RC room in the stead of one whose runs are dear.

#include <functional>
#include <memory>
#include <optional>

#include "tools/gap/model/counted_engine.hpp"
#include "tools/gap/surrogate/surrogate_engine.hpp"
#include "tools/gap/verdict/workflow.hpp"

namespace airside::tools::gap {

class AskedModel {
 public:
  /// `model` is kept by reference. `replayed` is called after each run of what answers, `ran` after each run of a model
  /// in whose stead an RC room answers.
  explicit AskedModel(const Engine& model, std::function<void()> replayed = {}, std::function<void()> ran = {});
  AskedModel(const AskedModel&) = delete;
  AskedModel& operator=(const AskedModel&) = delete;

  /// What answers; it lives through stretches.
  const Engine& engine() const { return answering_ ? static_cast<const Engine&>(*answering_) : model_; }
  /// The model itself; it lives through stretches.
  const Engine& model() const { return model_; }
  bool by_surrogate() const { return surrogate_ != nullptr; }
  /// Cost: as simulate_responses() of both windows.
  WindowResponses responses(const Library& library, const CaseData& data, int jobs) const;
  /// analyse(), or analyse_dear() by the surrogate; `responses` then hold what was learned.
  Verdict analyse(const CaseData& data, WindowResponses& responses, const Rules& rules, int jobs = 1,
                  const std::function<void(const Outlook&)>& look = {},
                  const std::function<void(const Analysed&)>& judged = {});

 private:
  CountedEngine counted_;
  StretchedEngine model_;
  std::unique_ptr<SurrogateEngine> surrogate_;
  std::optional<CountedEngine> answering_;
};

}  // namespace airside::tools::gap
