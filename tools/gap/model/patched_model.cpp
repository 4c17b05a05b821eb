#include "tools/gap/model/patched_model.hpp"

#include <fmt/format.h>

#include <fstream>

#include "hal/storage/digest64.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/json/merge_patch.hpp"
#include "tools/gap/any_model/effect_patch.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

/// Every value that the patch sets, with what stood there.
void list_edits(const json* before, const json& patch, const std::string& path, std::vector<ModelEdit>& edits) {
  for (const auto& [key, value] : patch.items()) {
    const std::string where = path.empty() ? key : path + " / " + key;
    const json* old = before != nullptr && before->is_object() && before->contains(key) ? &(*before)[key] : nullptr;
    if (value.is_object() && !value.empty())
      list_edits(old, value, where, edits);
    else
      edits.push_back({where, old != nullptr ? *old : json(), value});
  }
}

std::string how_text(const sim::EffectOp& op, double m) {
  switch (op.by) {
    case sim::By::multiply: return fmt::format("times {:.4g}", m);
    case sim::By::add: return fmt::format("{:+.4g}", m);
    case sim::By::set: return fmt::format("set to {:.4g}", m);
    case sim::By::raise: return fmt::format("at least {:.4g}", m);
    case sim::By::lower: return fmt::format("at most {:.4g}", m);
    case sim::By::drift: return fmt::format("drifts by {:.4g} a day", m);
    case sim::By::lag: return fmt::format("lags by {:.4g} s", m);
    case sim::By::exchange: return fmt::format("a share of {:.3g} of the other sensor of the pair", m);
    case sim::By::jet: return fmt::format("a share of {:.3g} of the supply temperature", m);
    case sim::By::divide: return fmt::format("divided by {:.4g}", m);
    case sim::By::shift: return fmt::format("{:+.4g} h later", m);
  }
  return "";
}

/// What the change does that no model file holds.
std::vector<std::string> beside_model(const sim::EffectChange& change,
                                      const std::vector<sim::EffectOp> sim::Effect::*model) {
  using On = sim::EffectOp::On;
  std::vector<std::string> lines;
  const sim::Effect& effect = *change.at.effect;
  const auto say = [&](const sim::EffectOp& op) {
    const char* what = op.on == On::loop      ? "loop beside the engine"
                       : op.on == On::command ? "recorded command"
                       : op.on == On::clock   ? "clock of the log"
                       : op.on == On::weather ? "measured weather"
                       : op.on == On::sensor  ? "sensor"
                                              : nullptr;
    if (what == nullptr) return;
    const double m = op.offset + op.factor * change.magnitude;
    const std::string place = effect.place == sim::PlaceKind::floor ? "" : fmt::format(" {}", change.at.place + 1);
    if (op.on == On::clock)
      lines.push_back(fmt::format("{}: {:+.4g} h", what, m));
    else
      lines.push_back(fmt::format("{} {}{}: {}", what, op.field, place, how_text(op, m)));
  };
  for (const sim::EffectOp& op : effect.common) say(op);
  if (model != nullptr) {
    for (const sim::EffectOp& op : effect.*model) say(op);
  }
  return lines;
}

json field_value(const sim::RcRoom& room, const sim::RoomField& field) {
  if (const auto* scalar = std::get_if<sim::ScalarField>(&field.member)) return room.*(*scalar);
  return room.*std::get<sim::ListField>(field.member);
}

void finish_patch(PatchedModel& out) {
  out.after = sim::merge_patched(out.before, out.patch, "patch");
  out.reverse = reverse_patch(out.before, out.patch);
}

}  // namespace

json model_changes(const json& model, const sim::ModelNames& names, const std::optional<sim::OwnNames>& own,
                   std::span<const sim::EffectChange> changes) {
  return own ? any_model_patch(model, *own, changes) : sim::model_patch(model, names, changes);
}

PatchedModel patched_energyplus(json model, const sim::ModelNames& names, const Changes& changes,
                                const std::optional<sim::OwnNames>& own) {
  PatchedModel out;
  out.before = std::move(model);
  out.patch = json::object();
  json now = out.before;
  for (const sim::EffectChange& change : changes) {
    const json step = model_changes(now, names, own, std::span(&change, 1));
    PatchedChange entry{change, {}, beside_model(change, own ? &sim::Effect::any_model : &sim::Effect::energyplus)};
    list_edits(&now, step, "", entry.edits);
    now.merge_patch(step);
    out.patch.merge_patch(step);
    out.changes.push_back(std::move(entry));
  }
  finish_patch(out);
  return out;
}

PatchedModel patched_room(json file, sim::RcRoom room, const Changes& changes) {
  PatchedModel out;
  out.before = std::move(file);
  out.patch = json::object();
  for (const sim::EffectChange& change : changes) {
    const sim::RcRoom next = sim::changed_room(room, std::span(&change, 1));
    PatchedChange entry{change, {}, beside_model(change, nullptr)};
    for (const sim::RoomField& field : sim::room_fields()) {
      const json was = field_value(room, field), is = field_value(next, field);
      if (was == is) continue;
      entry.edits.push_back({std::string(field.name), was, is});
      out.patch[std::string(field.name)] = is;
    }
    room = next;
    out.changes.push_back(std::move(entry));
  }
  finish_patch(out);
  return out;
}

void check_patched_energyplus(const PatchedModel& patched, const std::string& place) {
  const std::filesystem::path schema = sim::find_energyplus().schema;
  sim::lint_epjson(patched.patch, schema, {place + " (the patch)", sim::LintScope::patch});
  sim::lint_epjson(patched.after, schema, {place + " (the patched model)", sim::LintScope::whole});
}

json reverse_patch(const json& model, const json& patch) {
  json reverse = json::object();
  for (const auto& [key, value] : patch.items()) {
    if (!model.contains(key))
      reverse[key] = nullptr;
    else if (value.is_object() && model[key].is_object())
      reverse[key] = reverse_patch(model[key], value);
    else
      reverse[key] = model[key];
  }
  return reverse;
}

std::string model_digest(const json& model) {
  const std::string text = model.dump();
  return fmt::format("digest64:{:016x}", hal::digest64(std::as_bytes(std::span(text))));
}

json reverted_model(const json& model, const json& ledger, const std::string& model_place,
                    const std::string& ledger_place) {
  const auto text = [&](const char* key) {
    if (!ledger.is_object() || !ledger.contains(key) || !ledger[key].is_string()) {
      throw hal::InputError(ledger_place + ": " + key, "no such text", "a ledger that airside gap wrote",
                            "give the ledger.json that lies beside the patch");
    }
    return ledger[key].get<std::string>();
  };
  const std::string before = text("digest_before"), after = text("digest_after");
  if (!ledger.contains("reverse") || !ledger["reverse"].is_object()) {
    throw hal::InputError(ledger_place + ": reverse", "no object", "the patch that leads back",
                          "give the ledger.json that lies beside the patch");
  }
  const std::string found = model_digest(model);
  if (found == before) {
    throw hal::InputError(model_place, "the model as it was before the patch", "the patched model",
                          "nothing has to be taken back");
  }
  if (found != after) {
    throw hal::InputError(model_place, "a model with " + found, "the patched model of the ledger, " + after,
                          "it was changed since: take the ledger's \"reverse\" back by hand, newest change first");
  }
  json back = sim::merge_patched(model, ledger["reverse"], ledger_place + ": reverse");
  if (model_digest(back) != before) {
    throw hal::InputError(ledger_place + ": reverse", "a way to " + model_digest(back),
                          "to the model before, " + before,
                          "the ledger was edited: use the model file that was patched");
  }
  return back;
}

void write_whole_file(const std::filesystem::path& file, const std::string& text) {
  std::error_code failed;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), failed);
  hal::StagedFile staged(file.string());
  staged.write(text);
  staged.commit();
}

}  // namespace airside::tools::gap
