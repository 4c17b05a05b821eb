#pragma once
// The controller's columns of a log, one table for writer and reader.

#include <array>

#include "hal/log/log_csv.hpp"

namespace airside::hal {

/// Name of a column and the field of ControllerColumns that it shows; one of the two pointers is null.
struct ControllerColumn {
  const char* name;
  double ControllerColumns::*number;
  std::string ControllerColumns::*text;
};

constexpr auto controller_columns = std::to_array<ControllerColumn>({
    {"mode", nullptr, &ControllerColumns::mode},
    {"reason", nullptr, &ControllerColumns::reason},
    {"a_network_degc", &ControllerColumns::a_network_degc, nullptr},
    {"a_head_degc", &ControllerColumns::a_head_degc, nullptr},
    {"a_expert_degc", &ControllerColumns::a_expert_degc, nullptr},
    {"a_g36_degc", &ControllerColumns::a_g36_degc, nullptr},
    {"confidence", &ControllerColumns::confidence, nullptr},
    {"loss_strb", &ControllerColumns::loss_strb, nullptr},
    {"loss_tdb", &ControllerColumns::loss_tdb, nullptr},
    {"loss_gc", &ControllerColumns::loss_gc, nullptr},
    {"loss_rc", &ControllerColumns::loss_rc, nullptr},
    {"loss_rec", &ControllerColumns::loss_rec, nullptr},
    {"fault", nullptr, &ControllerColumns::fault},
    {"expected_held_degc", &ControllerColumns::expected_held_degc, nullptr},
    {"expected_error_k", &ControllerColumns::expected_error_k, nullptr},
    {"residual_forecast_k", &ControllerColumns::residual_forecast_k, nullptr},
    {"residual_share", &ControllerColumns::residual_share, nullptr},
});

}  // namespace airside::hal
