#pragma once
// A site on a desk for a real airsided under the probe: the plant is served by a thread of this process, so that a run
// costs little more than the daemon's own start; the probe records, kills or fails its calls.

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/modbus/server.hpp"
#include "sim/plant_model.hpp"
#include "support/bench.hpp"

namespace airside::power_loss {

/// What the probe is asked to do; texts as in io_probe.cpp.
struct ProbeOrder {
  std::string record = {};      ///< file to append the write log to
  std::string kill = {};        ///< "N:PHASE"
  std::string fail = {};        ///< "N:COUNT:ERRNO"
  std::string fail_every = {};  ///< "N:ERRNO"
  std::string fail_heap = {};   ///< "N:COUNT"
};

/// How a daemon ended.
struct DaemonRun {
  int code = -1;  ///< exit code, 128 + signal, or -1: hung and was killed
  bool killed_by_probe = false;
  long calls = 0;                                    ///< to files below the desk's box folder
  int files_early = 0, files_late = 0, threads = 0;  ///< open, at call 400 and at the end
  long allocations = 0;
  double seconds = 0;
};

struct DeskOptions {
  std::string name;
  int days = 2;
  int expert_days = 1;
  bool in_memory = true;
  int max_files = 40;
  double max_file_mb = 8;
  int crash_limit = 0;
};

class DaemonDesk {
 public:
  explicit DaemonDesk(DeskOptions options);
  ~DaemonDesk();
  DaemonDesk(const DaemonDesk&) = delete;
  DaemonDesk& operator=(const DaemonDesk&) = delete;

  /// The plant at its first instant, and an empty box.
  void reset();
  /// Runs airsided until `row` rows of the scored days are over, or it dies.
  DaemonRun run(int row, const ProbeOrder& order = {}, bool sync = false, const std::vector<std::string>& more = {});
  /// Copies the box aside; roll_back() makes box and plant as they were then, after `row` rows under these setpoints.
  void keep(const std::string& name);
  void roll_back(const std::string& name, int row, const std::map<std::int64_t, double>& setpoints);
  /// Puts a signed blob with this counter, or a wish, into the inbox; recorded if `record` names a write log.
  void push(int counter, const std::string& record = "");
  void wish(const std::string& name, const std::string& record = "");
  std::filesystem::path box() const { return bench_.file("box"); }
  std::filesystem::path file(const std::string& name) const { return bench_.file(name); }
  /// Rows of the log, oldest first.
  std::vector<std::string> rows() const;
  /// Setpoint in force by the plant's time, as clients wrote it.
  std::map<std::int64_t, double> setpoints() const;
  CivilTime time_of(int row) const { return {open_.seconds + row * std::int64_t{row_s}}; }
  /// Last words of the daemon.
  std::string said() const;
  void forget_words() { std::filesystem::remove(file("daemon.txt")); }
  std::string status() const;

 private:
  void serve();
  double write(const hal::Point& point, double value);
  void publish();
  int airside(std::vector<std::string> words, const std::string& record);
  void write_site(int port) const;

  DeskOptions options_;
  closed_loop::Bench bench_;
  CivilTime open_;
  std::unique_ptr<sim::PlantModel> model_;
  std::unique_ptr<hal::ModbusServer> server_;
  mutable std::mutex plant_;  ///< model_ and setpoints_
  std::map<std::int64_t, double> setpoints_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace airside::power_loss
