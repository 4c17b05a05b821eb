#include "sim/effects/effect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/input_error.hpp"
#include "sim/effects/effect_text.hpp"

namespace airside::sim {

namespace {

double changed(double x, By by, double m) {
  switch (by) {
    case By::multiply: return x * m;
    case By::add: return x + m;
    case By::set: return m;
    case By::raise: return std::max(x, m);
    case By::lower: return std::min(x, m);
    case By::divide: return x / m;
    default: return x;
  }
}

double amount(const EffectOp& op, double magnitude) { return op.offset + op.factor * magnitude; }

/// Not even by rounding, or by an object of no power, does an effect change a model at its null.
bool acts(const EffectChange& change) { return change.magnitude != change.at.effect->null_value; }

double kept(const EffectOp& op, double x) { return std::clamp(x, op.lowest, op.highest); }

/// Calls f(op, place, m') for each operation of the change on one kind of thing; place -1: everywhere.
template <class F>
void each_op(std::span<const EffectChange> changes, const std::vector<EffectOp> Effect::*ops, EffectOp::On on, F&& f) {
  for (const EffectChange& change : changes) {
    const Effect& effect = *change.at.effect;
    if (!acts(change)) continue;
    for (const EffectOp& op : effect.*ops) {
      if (op.on == on) f(op, effect.place == PlaceKind::floor ? -1 : change.at.place, amount(op, change.magnitude));
    }
  }
}

/// Changes on/off commands; what lies between becomes rows of on and off in that proportion.
void change_commands(std::vector<RecordedRow>& rows, std::vector<double> RecordedRow::*list, int place, By by,
                     double m) {
  std::vector<double> owed((rows.front().*list).size(), 0.0);
  for (RecordedRow& row : rows) {
    for (std::size_t i = 0; i < owed.size(); ++i) {
      double& on = (row.*list)[i];
      if (place >= 0 && place != static_cast<int>(i)) continue;
      const double share = std::clamp(changed(on, by, m), 0.0, 1.0);
      if (share != on && share > 0 && share < 1) {
        owed[i] += share;
        on = owed[i] > 0.5 ? 1 : 0;
        owed[i] -= on;
      } else {
        on = share;
      }
    }
  }
}

/// Where the effect's place lies in a list that repeats as the field does.
int index_of(const EffectChange& change, Repeats repeats, const RcRoom& room) {
  const PlaceKind kind = change.at.effect->place;
  if (kind == PlaceKind::fcu && repeats == Repeats::zone) return room.vavs + change.at.place;
  if (kind == PlaceKind::floor || kind == PlaceKind::facade) return -1;
  return change.at.place;
}

/// `field`: "solar" or "humidity".
std::shared_ptr<const Weather> changed_station(const Weather& station, const std::string& field, By by, double m) {
  std::vector<WeatherRecord> records = station.records();
  for (WeatherRecord& r : records) {
    if (field == "humidity") {
      r.relative_humidity_pct = std::clamp(changed(r.relative_humidity_pct, by, m), 1.0, 100.0);
      continue;
    }
    for (double* sun : {&r.direct_normal_w_m2, &r.diffuse_horizontal_w_m2, &r.global_horizontal_w_m2})
      *sun = std::max(0.0, changed(*sun, by, m));
  }
  return std::make_shared<const Weather>(station.location(), station.description(), station.interval_s(),
                                         station.first_interval(), std::move(records));
}

Eigen::VectorXd lagged(const Eigen::VectorXd& x, double lag_s) {
  const double share = lag_s > 0 ? 1 - std::exp(-row_s / lag_s) : 1;
  Eigen::VectorXd y = x;
  for (Eigen::Index i = 1; i < y.size(); ++i) y(i) = y(i - 1) + share * (x(i) - y(i - 1));
  return y;
}

void change_sensor(ChannelTable& table, const ChannelTable& truth, const Channels& channels, const EffectOp& op,
                   int place, double m) {
  const auto columns = effect_text::sensor_columns(op.field, channels);
  for (int i = 0; i < columns.count; ++i) {
    if (op.by == By::exchange) {
      const auto [a, b] = vav_pair(place, channels.rooms);
      table.col(a) = (1 - m) * truth.col(a) + m * truth.col(b);
      table.col(b) = (1 - m) * truth.col(b) + m * truth.col(a);
      return;
    }
    if (place >= 0 && place != i) continue;
    auto column = table.col(columns.first + i);
    switch (op.by) {
      case By::drift:
        column +=
            m / rows_per_day * Eigen::VectorXd::LinSpaced(column.size(), 0, static_cast<double>(column.size() - 1));
        break;
      case By::lag: column = lagged(column, m); break;
      case By::jet: column = (1 - m) * column + m * truth.col(channels.supply_temp()); break;
      default:
        for (double& x : column) x = changed(x, op.by, m);
    }
  }
}

/// The model's own value of the field.
double number_of(const nlohmann::json& object, const EffectOp& op, const std::string& name, const Effect& effect) {
  const auto found = object.find(op.field);
  if (found != object.end() && found->is_number()) return found->get<double>();
  if (op.by == By::set) return 0;
  throw hal::InputError(effect.file,
                        op.type + " / " + name + " / " + op.field + " is " +
                            (found == object.end() ? "left to the engine's default" : found->dump()),
                        "a number in the model, which the effect can change", "write the number into the model");
}

}  // namespace

std::string EffectAt::id() const {
  switch (effect->place) {
    case PlaceKind::floor: return effect->name;
    case PlaceKind::facade: return effect->name + "@" + effect_text::facade_name(place);
    default: return effect->name + "@" + std::to_string(place + 1);
  }
}

std::string EffectAt::text() const {
  const std::string n = std::to_string(place + 1);
  std::string text = effect->title;
  effect_text::replace_all(text, "{facade}", effect->place == PlaceKind::facade ? effect_text::facade_name(place) : "");
  effect_text::replace_all(text, "{n}", n);
  return text;
}

std::pair<int, int> vav_pair(int place, int vavs) {
  int a = 0;
  while (place >= vavs - 1 - a) place -= vavs - 1 - a++;
  return {a, a + 1 + place};
}

std::vector<EffectAt> places_of(const Effect& effect, const Channels& channels,
                                const std::array<bool, facades>& has_facade) {
  int count = 1;
  switch (effect.place) {
    case PlaceKind::floor: break;
    case PlaceKind::facade: count = facades; break;
    case PlaceKind::zone: count = channels.rooms + channels.fcus; break;
    case PlaceKind::vav: count = channels.rooms; break;
    case PlaceKind::fcu: count = channels.fcus; break;
    case PlaceKind::vav_pair: count = channels.rooms * (channels.rooms - 1) / 2; break;
  }
  std::vector<EffectAt> places;
  for (int i = 0; i < count; ++i) {
    if (effect.place != PlaceKind::facade || has_facade[static_cast<std::size_t>(i)]) places.push_back({&effect, i});
  }
  return places;
}

RcRoom changed_room(RcRoom room, std::span<const EffectChange> changes) {
  for (const EffectChange& change : changes) {
    if (!acts(change)) continue;
    for (const EffectOp& op : change.at.effect->rc) {
      const std::string name = effect_text::filled(op.field, change.at, "");
      const RoomField* field = find_room_field(name);
      const double m = amount(op, change.magnitude);
      const auto clamped = [field](double x) { return std::clamp(x, field->lowest, field->highest); };
      if (const auto* scalar = std::get_if<ScalarField>(&field->member)) {
        room.*(*scalar) = clamped(changed(room.*(*scalar), op.by, m));
      } else {
        auto& list = room.*std::get<ListField>(field->member);
        const int only = index_of(change, field->repeats, room);
        for (int i = 0; i < std::ssize(list); ++i) {
          double& x = list[static_cast<std::size_t>(i)];
          if (only < 0 || only == i) x = clamped(changed(x, op.by, m));
        }
      }
    }
  }
  return room;
}

Recording changed_recording(Recording recording, std::span<const EffectChange> changes) {
  each_op(changes, &Effect::common, EffectOp::On::clock, [&](const EffectOp&, int, double hours) {
    recording.from.seconds -= 180 * std::llround(hours * 3600 / 180);
  });
  each_op(changes, &Effect::common, EffectOp::On::command, [&](const EffectOp& op, int place, double m) {
    if (op.by == By::lag) {
      double lagging = recording.rows.front().setpoint_degc;
      const double share = m > 0 ? 1 - std::exp(-row_s / m) : 1;
      for (RecordedRow& row : recording.rows) row.setpoint_degc = lagging += share * (row.setpoint_degc - lagging);
      return;
    }
    if (op.field == "vav_on") change_commands(recording.rows, &RecordedRow::vav_on, place, op.by, m);
    if (op.field == "fcu_on") change_commands(recording.rows, &RecordedRow::fcu_on, place, op.by, m);
    if (op.field != "setpoint") return;
    for (RecordedRow& row : recording.rows) row.setpoint_degc = changed(row.setpoint_degc, op.by, m);
  });
  each_op(changes, &Effect::common, EffectOp::On::weather, [&](const EffectOp& op, int, double m) {
    if (op.field != "outdoor_temp") {
      recording.station = changed_station(*recording.station, op.field, op.by, m);
      return;
    }
    for (RecordedRow& row : recording.rows) row.outdoor_temp_degc = changed(row.outdoor_temp_degc, op.by, m);
  });
  return recording;
}

ChannelTable changed_sensors(ChannelTable table, const Channels& channels, std::span<const EffectChange> changes) {
  each_op(changes, &Effect::common, EffectOp::On::sensor, [&](const EffectOp& op, int place, double m) {
    const ChannelTable truth = table;
    change_sensor(table, truth, channels, op, place, m);
  });
  return table;
}

double changed_number(const EffectOp& op, double x, double magnitude) {
  return kept(op, changed(x, op.by, amount(op, magnitude)));
}

RoomLoopOptions changed_loops(RoomLoopOptions loops, std::span<const EffectChange> changes,
                              const std::vector<EffectOp> Effect::*ops) {
  each_op(changes, ops, EffectOp::On::loop, [&](const EffectOp& op, int place, double m) {
    for (int i = 0; op.field == "damper" && i < std::ssize(loops.dampers); ++i) {
      double& damper = loops.dampers[static_cast<std::size_t>(i)];
      if (place < 0 || place == i) damper = kept(op, changed(damper, op.by, m));
    }
    if (double* scalar = effect_text::loop_field(loops, op.field)) *scalar = kept(op, changed(*scalar, op.by, m));
  });
  return loops;
}

nlohmann::json model_patch(const nlohmann::json& model, const ModelNames& names,
                           std::span<const EffectChange> changes) {
  nlohmann::json patch = nlohmann::json::object(), now = model;
  for (const EffectChange& change : changes) {
    if (!acts(change)) continue;
    for (const EffectOp& op : change.at.effect->energyplus) {
      if (op.on != EffectOp::On::model) continue;
      const double m = amount(op, change.magnitude);
      bool touched = false;
      for (const EffectAt& at : effect_text::places_of_op(op, change.at, names)) {
        const std::string zone = effect_text::zone_of(at, names);
        const std::string name = effect_text::filled(op.name, at, zone);
        if (!op.object.is_null()) {
          patch[op.type][name] = now[op.type][name] = effect_text::filled(op.object, at, zone, m);
          touched = true;
          continue;
        }
        if (!now.contains(op.type)) continue;
        for (auto& [key, object] : now[op.type].items()) {
          if (!effect_text::matches(name, key)) continue;
          const double x = number_of(object, op, key, *change.at.effect);
          patch[op.type][key][op.field] = object[op.field] = kept(op, changed(x, op.by, m));
          touched = true;
        }
      }
      if (!touched) {
        throw hal::InputError(change.at.effect->file, "no " + op.type + " named '" + op.name + "' in the model",
                              "an object that the effect can change",
                              "name it as the twin does, or leave the effect out");
      }
    }
  }
  return patch;
}

}  // namespace airside::sim
