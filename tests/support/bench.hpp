#pragma once
// One site on a bench: a folder with site file, point map, weights and the schedule's days; the same room once in this
// process and once behind `airside serve` with a real `airsided` beside it.

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/child.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::closed_loop {

struct BenchOptions {
  std::string name;  ///< of the folder
  std::string topology = "5vav-5fcu-2power";
  tools::PlantChoice plant = {};  ///< kind "rc" unless said otherwise
  int expert_days = 1;            ///< under the schedule before, remembered from history.csv
  int days = 1;
  bool in_memory = true;            ///< folder on a memory file system where there is one
  bool serial = false;              ///< RTU over a pseudo-terminal
  std::string setpoint_point = {};  ///< row of the point map in the place of the default's
  hal::StandIns stand_ins = {};     ///< for signals that the site has no sensor for
  std::string more_points = {};     ///< rows at the end of the point map
  std::string more_site = {};       ///< text at the end of the site file
  int cycle_min = 18;               ///< control cycle
  bool band = false;                ///< the objective band, without weights, on a room whose boxes modulate
};

/// BenchOptions::more_site of days that are not about learning: updates from few transitions.
inline constexpr const char* brief_learning = "[controller.override]\nbatch = 16\nrecent_in_batch = 4\n";

/// The daemon's rows as text, oldest first, and the header line of its files.
struct LogText {
  std::string header;
  std::vector<std::string> rows;
};

class Bench {
 public:
  explicit Bench(BenchOptions options);
  ~Bench();

  /// Rows of the same days by run_controller() in this process, as the log writes them.
  const LogText& expected();
  /// Starts `airside serve`; waits until it answers.
  void start_server();
  void stop_server() { server_.reset(); }
  int server_pid() const { return server_->pid(); }
  /// Starts `airsided` for the scored days.
  std::unique_ptr<Child> start_daemon(bool sync = false, const std::vector<std::string>& more = {});
  /// What stands in the daemon's log folder now.
  LogText log() const;
  /// Number of whole rows in the log folder; cheap.
  std::size_t logged_rows() const;

  tools::Trial trial() const { return trial_; }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  /// The daemon's status.json, discarded where there is none within 10 s. Its two files change places, so that a look
  /// that lasts over two rows sees the next one being written: it is taken again.
  nlohmann::json status() const;
  /// Of this build; airsided is that of $AIRSIDE_DAEMON where it is set, such as the one of an unpacked package.
  std::filesystem::path program(const std::string& name) const;
  const tools::ControlRun& run() const { return run_; }
  std::size_t rows() const { return static_cast<std::size_t>(options_.days) * rows_per_day; }

 private:
  void write_site(const std::string& transport) const;

  BenchOptions options_;
  std::filesystem::path folder_;
  tools::Trial trial_;
  tools::BlobBytes blob_;
  tools::Prepared prepared_;
  tools::ControlRun run_;
  LogText expected_;
  std::unique_ptr<Child> server_;
};

/// The room "301" of the RC plant, everything else as default.
tools::PlantChoice rc_room(const std::string& room = "301", const std::string& start = "2021-08-01");

/// Number in environment variable `name`, else `otherwise`.
int from_environment(const char* name, int otherwise);

/// Fails at the first row that differs, and shows both.
void expect_same_rows(const LogText& log, const LogText& expected);

}  // namespace airside::closed_loop
