// script_writer FOLDER STEPS: resumes from FOLDER, then commits and logs so many steps of a script, as the daemon does.
#include <cstdio>
#include <cstdlib>

#include "hal/log/row_log.hpp"
#include "power_loss/power_cut.hpp"
#include "power_loss/state_script.hpp"

int main(int argc, char** argv) {
  using namespace airside;
  using namespace airside::hal;
  if (argc != 3) return 2;
  const std::string folder = argv[1];
  const StoreLayout layout = power_loss::script_layout();
  const TopologyCounts counts = counts_of<ThreeVav>();
  auto store = DurableStore::open((folder + "/state").c_str(), layout);
  RowLog log((folder + "/log").c_str(), counts, {.max_files = 3, .max_file_bytes = 100'000});
  StateScript script(layout);
  if (!store || !store->ready() || !log.ready()) return 3;
  const auto loaded = store->load(script.buffers());
  if (!loaded) return 4;
  if (loaded->outcome != LoadOutcome::none) {
    script.resume(loaded->replay_count);
    if (!log.resume(loaded->log)) return 5;
  }
  for (int i = 0; i < std::atoi(argv[2]); ++i) {
    script.advance();
    LogRow row = make_log_row(counts);
    row.time = {1625097600 + static_cast<std::int64_t>(script.step) * row_s};
    for (std::size_t j = 0; j < row.value.size(); ++j) row.value[j] = 20.0;
    row.setpoint_degc = static_cast<double>(200000 + script.step % 60000) / 1e4;
    const auto appended = log.append(row);
    if (!appended && !(script.step == 1 && appended.error().fault == StoreFault::out_of_order)) return 6;
    if (!log.sync()) return 7;
    StoredState state = script.stored();
    state.log = log.position();
    if (!store->commit(state)) return 8;
  }
  return 0;
}
