#include <map>

#include "hal/site/site_log.hpp"
#include "hal/text/input_error.hpp"
#include "module.hpp"
#include "tools/run/site.hpp"

namespace airside::python {

namespace {

/// A named number of the controller's, and where it is in a row.
struct ControllerNumber {
  const char* name;
  double hal::ControllerColumns::*place;
};
constexpr ControllerNumber controller_numbers[] = {
    {"a_network_degc", &hal::ControllerColumns::a_network_degc},
    {"a_head_degc", &hal::ControllerColumns::a_head_degc},
    {"a_expert_degc", &hal::ControllerColumns::a_expert_degc},
    {"a_g36_degc", &hal::ControllerColumns::a_g36_degc},
    {"confidence", &hal::ControllerColumns::confidence},
    {"loss_strb", &hal::ControllerColumns::loss_strb},
    {"loss_tdb", &hal::ControllerColumns::loss_tdb},
    {"loss_gc", &hal::ControllerColumns::loss_gc},
    {"loss_rc", &hal::ControllerColumns::loss_rc},
    {"loss_rec", &hal::ControllerColumns::loss_rec},
    {"expected_held_degc", &hal::ControllerColumns::expected_held_degc},
    {"expected_error_k", &hal::ControllerColumns::expected_error_k},
    {"residual_forecast_k", &hal::ControllerColumns::residual_forecast_k},
    {"residual_share", &hal::ControllerColumns::residual_share}};

std::vector<std::string> names_of(const hal::TopologyCounts& counts, bool controller) {
  std::vector<std::string> names;
  for (int i = 0; i < counts.signals(); ++i) names.push_back(hal::column_of(counts, i));
  names.insert(names.end(), {"setpoint_degc", "supply_temp_degc"});
  for (const hal::SideColumn& side : counts.sides) names.push_back(hal::column_of(side));
  if (controller) {
    for (const ControllerNumber& number : controller_numbers) names.emplace_back(number.name);
  }
  return names;
}

void fill(double* to, const hal::LogRow& row, std::size_t sides, bool controller) {
  for (const double value : row.value) *to++ = value;
  *to++ = row.setpoint_degc;
  *to++ = row.supply_temp_degc;
  for (std::size_t i = 0; i < sides; ++i) *to++ = i < row.side.size() ? row.side[i] : hal::ControllerColumns::none;
  if (!controller) return;
  for (const ControllerNumber& number : controller_numbers) *to++ = row.controller.*number.place;
}

nb::dict read_log(const std::string& path, const std::optional<std::string>& site, const std::string& topology,
                  bool keep_missing) {
  const tools::Site chosen = site ? tools::load_site(*site) : tools::built_in_site(topology);
  hal::LogReadOptions options;
  options.keep_missing = keep_missing;
  const hal::Log log = [&] {
    const nb::gil_scoped_release free;
    return hal::read_log(path, chosen.counts, options);
  }();
  hal::TopologyCounts counts = chosen.counts;
  nb::dict out = dict_of(counts, log.rows, log.has_controller, log.extra_columns);
  out["missing_rows"] = log.summary.missing_rows;
  out["missing_values"] = log.summary.missing_values;
  return out;
}

}  // namespace

nb::dict dict_of(const hal::TopologyCounts& counts, const std::vector<hal::LogRow>& rows, bool controller,
                 const std::vector<std::string>& extra_columns) {
  const std::vector<std::string> names = names_of(counts, controller);
  const std::size_t width = names.size(), height = rows.size();
  auto* values = new double[width * height + 1];
  auto* times = new std::int64_t[height + 1];
  const nb::capsule values_owner(values, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  const nb::capsule times_owner(times, [](void* p) noexcept { delete[] static_cast<std::int64_t*>(p); });
  std::map<std::string, nb::list> texts;
  for (std::size_t i = 0; i < height; ++i) {
    const hal::LogRow& row = rows[i];
    times[i] = row.time.seconds;
    fill(values + i * width, row, counts.sides.size(), controller);
    if (controller) {
      texts["mode"].append(row.controller.mode);
      texts["reason"].append(row.controller.reason);
      texts["fault"].append(row.controller.fault);
    }
    for (std::size_t k = 0; k < extra_columns.size(); ++k)
      texts[extra_columns[k]].append(k < row.extra.size() ? row.extra[k] : std::string());
  }
  nb::dict text_dict;
  for (const auto& [name, list] : texts) text_dict[name.c_str()] = list;
  nb::dict out;
  out["topology"] = counts.name;
  out["names"] = names;
  out["time"] = nb::ndarray<nb::numpy, std::int64_t, nb::ndim<1>>(times, {height}, times_owner);
  out["values"] = nb::ndarray<nb::numpy, double, nb::ndim<2>>(values, {height, width}, values_owner);
  out["texts"] = text_dict;
  return out;
}

void add_log(nb::module_& m) {
  m.def("read_log", &read_log, nb::arg("path"), nb::arg("site").none(), nb::arg("topology"), nb::arg("keep_missing"),
        "Rows of a log file, or of all logs of a folder, as arrays.");
}

}  // namespace airside::python
