#include "tools/gap/verdict_json.hpp"

#include <fmt/format.h>

namespace airside::tools::gap {

namespace {

constexpr double z95 = 1.96;

nlohmann::json json_of(const Finding& f) {
  nlohmann::json alike = nlohmann::json::array();
  for (const sim::EffectAt& at : f.cannot_tell_from) alike.push_back(at.id());
  const sim::Effect& effect = *f.at.effect;
  return {{"id", f.at.id()},
          {"text", f.at.text()},
          {"magnitude", f.magnitude},
          {"unit", effect.unit},
          {"null", effect.null_value},
          {"interval", {f.magnitude - z95 * f.sd, f.magnitude + z95 * f.sd}},
          {"gain", f.gain},
          {"margin", f.margin},
          {"same_sign_share", f.same_sign},
          {"class", alike},
          {"why_not", f.why_not},
          {"looks_like", effect.looks_like},
          {"confirm", effect.confirm}};
}

}  // namespace

nlohmann::json json_of(const Verdict& v, const std::string& name, const Responses& responses,
                       const sim::Channels& channels) {
  nlohmann::json effects = nlohmann::json::array(), ranking = nlohmann::json::array(), by_channel;
  for (const Finding& f : v.findings) effects.push_back(json_of(f));
  for (std::size_t i = 0; i < v.ranking.size() && i < 10; ++i) {
    ranking.push_back(responses.candidates[v.ranking[i].candidate].at.id());
  }
  for (int c = 0; c < channels.count() && v.locked.rmse_before.size() == channels.count(); ++c) {
    by_channel[channels.name(c)] = {{"rmse_before", v.locked.rmse_before(c)}, {"rmse_after", v.locked.rmse_after(c)}};
  }
  return {{"case", name},
          {"verdict", text_of(v.kind)},
          {"reason", v.reason},
          {"effects", effects},
          {"ranking", ranking},
          {"best_gain", v.best_gain},
          {"gain_limit", v.gain_limit},
          {"leftover", v.leftover},
          {"locked",
           {{"score_before", v.locked.score_before},
            {"score_after", v.locked.score_after},
            {"score_floor", v.locked.score_floor},
            {"temp_rmse_before_k", v.locked.temp_rmse_before_k},
            {"temp_rmse_after_k", v.locked.temp_rmse_after_k},
            {"power_rmse_before_kw", v.locked.power_rmse_before_kw},
            {"power_rmse_after_kw", v.locked.power_rmse_after_kw},
            {"channels", by_channel}}}};
}

std::string sentence_of(const Finding& f) {
  std::string text = fmt::format("{}: {:.3g} {} +- {:.2g}", f.at.text(), f.magnitude, f.at.effect->unit, z95 * f.sd);
  if (!f.cannot_tell_from.empty()) {
    std::string alike;
    for (const sim::EffectAt& at : f.cannot_tell_from) alike += (alike.empty() ? "" : "; or ") + at.text();
    text += "; the data cannot tell it from: " + alike;
  }
  return text;
}

}  // namespace airside::tools::gap
