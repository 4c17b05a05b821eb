#include "tools/gap/bills/bill_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

using nlohmann::json;

json json_of(const BillVerdict& v, const BillTable& table) {
  json j{{"format", 1},
         {"sentence", sentence_of(v)},
         {"named", v.named},
         {"nothing", v.nothing},
         {"other", v.other},
         {"set", v.set},
         {"candidates", json::array()},
         {"meters", json::array()},
         {"not_visible", json::array()}};
  for (const BillCandidate& c : v.candidates) {
    j["candidates"].push_back({{"id", c.at.id()},
                               {"text", c.at.text()},
                               {"probability", c.probability},
                               {"size", c.magnitude},
                               {"sd", c.sd},
                               {"unit", c.at.effect->unit},
                               {"kwh_per_day", c.kwh_per_day},
                               {"visible_from", finite_json(c.visible_from)}});
  }
  for (std::size_t m = 0; m < v.meters.size(); ++m) {
    const BillMeterFit& fit = v.meters[m];
    json rows = json::array();
    for (Eigen::Index p = 0; p < table.kwh.rows(); ++p) {
      rows.push_back({{"billed_kwh", finite_json(table.kwh(p, static_cast<Eigen::Index>(m)))},
                      {"model_kwh", v.simulated_kwh(p, static_cast<Eigen::Index>(m))}});
    }
    j["meters"].push_back({{"meter", fit.meter},
                           {"billed_kwh", fit.measured_kwh},
                           {"model_kwh", fit.simulated_kwh},
                           {"nmbe_percent", fit.nmbe_percent},
                           {"cv_rmse_percent", fit.cv_rmse_percent},
                           {"bills", rows}});
  }
  for (const sim::EffectAt& at : v.invisible) j["not_visible"].push_back(at.id());
  return j;
}

std::string text_of(const BillVerdict& v) {
  std::string text;
  text += fmt::format("{}\n\n", sentence_of(v));
  for (const BillMeterFit& fit : v.meters) {
    text += fmt::format(
        "{}: billed {:.0f} kWh, the model uses {:.0f}; NMBE {:.1f} % (5 % is calibrated), CV(RMSE) {:.1f} % "
        "(15 %)\n",
        fit.meter, fit.measured_kwh, fit.simulated_kwh, fit.nmbe_percent, fit.cv_rmse_percent);
  }
  constexpr std::size_t shown = 5;
  const auto first = std::span(v.set).first(std::min(shown, v.set.size()));
  text += fmt::format("\nhow probable (together {}{} hold 90 %):\n", fmt::join(first, ", "),
                      v.set.size() > shown ? fmt::format(" and {} more", v.set.size() - shown) : "");
  int rows = 0;
  for (const BillCandidate& c : v.candidates) {
    if (c.probability < 0.01 || ++rows > 8) break;
    text += fmt::format("  {:>5.1f} %  {}: {:.3g} ± {:.2g}{}, {:+.3g} kWh a day\n", 100 * c.probability, c.at.id(),
                        c.magnitude, 1.96 * c.sd, unit_suffix(*c.at.effect), c.kwh_per_day);
  }
  text += fmt::format("  {:>5.1f} %  nothing\n  {:>5.1f} %  something that no effect is\n\n", 100 * v.nothing,
                      100 * v.other);
  std::vector<std::string> from, never;
  for (const BillCandidate& c : v.candidates) {
    if (std::isfinite(c.visible_from))
      from.push_back(fmt::format("{} from {:.3g}{} on", c.at.id(), c.visible_from, unit_suffix(*c.at.effect)));
    else
      never.push_back(c.at.id());
  }
  for (const sim::EffectAt& at : v.invisible) never.push_back(at.id());
  text += fmt::format("what these bills could show: {}\n",
                      from.empty() ? "nothing" : fmt::format("{}", fmt::join(from, ", ")));
  if (!never.empty()) text += fmt::format("not visible in these bills: {}\n", fmt::join(never, ", "));
  return text;
}

}  // namespace airside::tools::gap
