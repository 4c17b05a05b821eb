#pragma once
// Parts of the extension. Each adds its functions; results are dicts of numbers, texts and numpy arrays, which the
// package's Python turns into its types.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <functional>
#include <vector>

#include "hal/log/log_csv.hpp"

namespace airside::python {

namespace nb = nanobind;

/// hal::InputError becomes airside.InputError, with its four parts.
void translate_errors();

void add_blob(nb::module_& m);
void add_log(nb::module_& m);
void add_simulate(nb::module_& m);
void add_gap(nb::module_& m);

/// Rows as a dict: `time` (seconds since 1970, local standard time), `names`, `values` (rows x names), `texts` by name.
nb::dict dict_of(const hal::TopologyCounts& counts, const std::vector<hal::LogRow>& rows, bool controller,
                 const std::vector<std::string>& extra_columns = {});

/// Calls `progress` (None: nothing) with the share of the work, and lets Ctrl-C end a run. The GIL need not be held.
/// `progress` must outlive the result.
std::function<void(double)> progress_of(const nb::object& progress);

}  // namespace airside::python
