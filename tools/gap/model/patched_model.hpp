#pragma once
// A model with what the gap workflow found in it: the patch, its reverse, and a ledger that says what was added, why
// and how sure that is.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/gap/model/engine.hpp"

namespace airside::tools::gap {

/// A value of the model that a change sets.
struct ModelEdit {
  std::string where;  ///< "WindowMaterial:SimpleGlazingSystem / P1 South Glazing / u_factor", or a room's field
  nlohmann::json before, after;  ///< null: not there
};

/// A change, and what it does to the model's file and beside it.
struct PatchedChange {
  sim::EffectChange change;
  std::vector<ModelEdit> edits;
  std::vector<std::string> beside;  ///< commands, clock, weather, sensors, loops: no model file holds them
};

/// All texts are JSON; patch and reverse are merge patches (RFC 7386).
struct PatchedModel {
  nlohmann::json before, patch, after, reverse;
  std::vector<PatchedChange> changes;
};

/// What the changes make of a model, as a merge patch; `own`: the names of one that controls its rooms itself.
/// Errors: hal::InputError as sim::model_patch.
nlohmann::json model_changes(const nlohmann::json& model, const sim::ModelNames& names,
                             const std::optional<sim::OwnNames>& own, std::span<const sim::EffectChange> changes);

/// The epJSON with the changes.  Errors: as model_changes().
PatchedModel patched_energyplus(nlohmann::json model, const sim::ModelNames& names, const Changes& changes,
                                const std::optional<sim::OwnNames>& own = std::nullopt);

/// The room's file with the changes; `room` is what load_room makes of it.
PatchedModel patched_room(nlohmann::json file, sim::RcRoom room, const Changes& changes);

/// Throws what is wrong with patch and patched model against the engine's schema.
/// Errors: hal::InputError.
void check_patched_energyplus(const PatchedModel& patched, const std::string& place);

/// The patch that undoes `patch` on what it made of `model`.
///   merge(merge(model, patch), reverse) = model, unless the model holds nulls.
nlohmann::json reverse_patch(const nlohmann::json& model, const nlohmann::json& patch);

/// "digest64:0123456789abcdef" of the JSON text with sorted keys and without blanks.
std::string model_digest(const nlohmann::json& model);

/// The model as it was before a ledger's changes.
/// Errors: hal::InputError for a ledger that is none, a model that is not the ledger's, and a reverse patch that does
/// not lead to the model before.
nlohmann::json reverted_model(const nlohmann::json& model, const nlohmann::json& ledger, const std::string& model_place,
                              const std::string& ledger_place);

/// Writes whole or not at all; makes the folder.
/// Errors: hal::InputError if the file cannot be written.
void write_whole_file(const std::filesystem::path& file, const std::string& text);

}  // namespace airside::tools::gap
