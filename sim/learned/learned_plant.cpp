#include "sim/learned/learned_plant.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"

namespace airside::sim {

LearnedPlant::LearnedPlant(std::shared_ptr<const LearnedEnvironment> environment, const hal::TopologyCounts& counts,
                           CivilTime start, double setpoint_degc)
    : environment_(std::move(environment)), vavs_(counts.vavs), fcus_(counts.fcus), powers_(counts.powers) {
  const std::vector<hal::LogRow>& rows = environment_->rows;
  const std::int64_t later_s = start.seconds - rows.front().time.seconds;
  if (later_s < 0 || later_s % row_s != 0 || start.seconds > rows.back().time.seconds) {
    throw hal::InputError(
        environment_->description, "a start at " + hal::civil_text(start),
        "a time from " + hal::civil_text(rows.front().time) + " to " + hal::civil_text(rows.back().time),
        "choose another --start, or leave it out");
  }
  row_ = static_cast<std::size_t>(later_s / row_s);
  const std::vector<double>& first = rows[row_].value;
  inputs_.resize(counts.signals() + 1);
  for (int r = 0; r < vavs_; ++r) inputs_(r) = first[static_cast<std::size_t>(r)];
  set_setpoint(setpoint_degc);
  show();
}

CivilTime LearnedPlant::time() const { return environment_->rows[row_].time; }

void LearnedPlant::advance_to(CivilTime t) {
  const std::int64_t ahead = t.seconds - time().seconds;
  if (ahead < 0 || ahead % row_s != 0) throw std::invalid_argument("a learned environment goes on by whole rows");
  for (std::int64_t done = 0; done < ahead; done += row_s) {
    if (row_ + 1 >= environment_->rows.size()) {
      throw hal::InputError(environment_->description, "the end of its log at " + hal::civil_text(time()),
                            "days until " + hal::civil_text(t), "run fewer --days or --expert-days");
    }
    inputs_.head(vavs_) += environment_->network.change_k(inputs_);
    ++row_;
    show();
  }
}

void LearnedPlant::set_setpoint(double setpoint_degc) {
  inputs_(inputs_.size() - 1) = setpoint_degc;
  sensors_.setpoint_degc = sensors_.supply_temp_degc = setpoint_degc;
}

void LearnedPlant::show() {
  const std::vector<double>& logged = environment_->rows[row_].value;
  for (int i = vavs_; i + 1 < inputs_.size(); ++i) inputs_(i) = logged[static_cast<std::size_t>(i)];
  int at = 0;
  const auto part = [&](std::vector<double>& out, int count) {
    out.assign(inputs_.data() + at, inputs_.data() + at + count);
    at += count;
  };
  part(sensors_.room_temp_degc, vavs_);
  for (double& degc : sensors_.room_temp_degc) degc = std::round(degc * 100) / 100;  // as sensors show it
  part(sensors_.fcu_temp_degc, fcus_);
  part(sensors_.vav_on, vavs_);
  part(sensors_.fcu_on, fcus_);
  part(sensors_.power_kw, powers_);
  sensors_.mau_temp_degc = inputs_(at);
  sensors_.outdoor_temp_degc = inputs_(at + 1);
  sensors_.rain = inputs_(at + 2);
}

std::string LearnedPlant::description() const { return environment_->description; }

}  // namespace airside::sim
