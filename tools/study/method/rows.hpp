#pragma once
// The rows of the studies of the published method: what each run is, and the figures that the publication prints.

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "airside/settings.hpp"

namespace airside::tools {

/// What a row is run for.
enum class MethodTable { control, score, ablation, physics, pretraining, deployment, data, neighbours, offline, cycle };
constexpr int method_tables = 10;

/// Its name on the command line.
const char* text_of(MethodTable table);

/// What is done in a run of a row.
enum class MethodWork {
  control,   ///< a room is controlled after schedule days
  pretrain,  ///< weights are pretrained; later rows of the same seed start from them
  physics,   ///< forecasts with and without the physics losses, on days that nobody trained on
  offline,   ///< forecasts of transferred, statically pretrained and untransferred weights in two seasons
};

/// What the network starts from before it is fine-tuned on the schedule's days.
enum class MethodStart { scratch, dynamic_twin, static_twin, operated_room };

/// A setting that differs from preset `paper`, by its name in setting_table.
struct MethodOverride {
  const char* name = nullptr;
  double value = 0;
};

/// A figure that the publication prints, by the key that runs give the same figure.
struct PublishedFigure {
  const char* key = nullptr;
  double value = 0;
};

struct MethodRow {
  const char* name;  ///< of files and tables
  MethodTable table;
  MethodWork work = MethodWork::control;
  MethodStart start = MethodStart::scratch;
  int data_days = 5;               ///< schedule days before control
  const char* baseline = nullptr;  ///< of baseline_names(); none: the published method
  bool is_product = false;         ///< preset `product` in the place of `paper`
  std::array<MethodOverride, 4> overrides{};
  std::array<PublishedFigure, 6> published{};
};

/// Every row, in the order in which it runs.
std::span<const MethodRow> method_rows();
/// The row of that name.  Errors: std::out_of_range.
const MethodRow& method_row(std::string_view name);

/// The rooms of a row's table on the physical plants; those that its weights are pretrained on.
std::vector<std::string> method_rooms(const MethodRow& row);
/// The room on which the weights for `room` are pretrained, and the row that does it; "" for scratch.
std::string source_room(MethodStart start, const std::string& room);
const char* source_row(MethodStart start);

/// Settings of a preset as the publication has them: nothing supervises the method; then the row's overrides.
ControllerSettings method_settings(ControllerSettings preset, const MethodRow& row);

}  // namespace airside::tools
