#include "support/bench.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "hal/log/log_csv.hpp"
#include "hal/points/point_map.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/weights/blob_file.hpp"
#include "tools/run/training/pretraining.hpp"

namespace airside::closed_loop {

namespace {

namespace fs = std::filesystem;

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + path.string());
}

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream in(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

LogText text_of_rows(const tools::Site& site, const std::vector<hal::LogRow>& rows) {
  LogText text;
  text.header = hal::log_header(site.counts, true);
  text.header.pop_back();
  std::vector<char> line(hal::max_log_row_text);
  for (const hal::LogRow& row : rows) {
    const std::size_t size = hal::format_log_row(line, row, true);
    text.rows.emplace_back(line.data(), size - 1);
  }
  return text;
}

/// Weights for the bench's room shape and control cycle: days of pretraining on the embedded plant, once a process.
tools::BlobBytes weights_for(const tools::Site& site) {
  static std::vector<std::pair<std::string, tools::BlobBytes>> made;
  const std::string wanted = fmt::format("{}, {} min", site.counts.name, site.settings.cycle_min);
  for (const auto& [name, blob] : made) {
    if (name == wanted) return blob;
  }
  tools::Site plain = tools::built_in_site(site.counts.name);
  plain.settings.cycle_min = plain.file.cycle_min = site.settings.cycle_min;
  const tools::PlantChoice twin = rc_room("301", "2021-07-01");
  const auto model = tools::make_plant(twin, plain, 4);
  const CivilTime until{tools::start_of(twin).seconds + 4 * 86400};
  made.emplace_back(wanted, tools::pretrain(plain, *model, until, {}).blob);
  return made.back().second;
}

}  // namespace

tools::PlantChoice rc_room(const std::string& room, const std::string& start) {
  tools::PlantChoice choice;
  choice.kind = "rc";
  choice.room = room;
  choice.start = start;
  choice.seed = 7;
  return choice;
}

int from_environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr || *text == '\0' ? otherwise : std::atoi(text);
}

Bench::Bench(BenchOptions options) : options_(std::move(options)) {
  const bool memory = options_.in_memory && fs::is_directory("/dev/shm");
  folder_ = (memory ? fs::path("/dev/shm") : fs::temp_directory_path()) /
            fmt::format("airside_loop_{}_{}", options_.name, ::getpid());
  fs::remove_all(folder_);
  for (const char* part : {"state", "log"}) fs::create_directories(folder_ / part);
  const tools::Site built_in = tools::built_in_site(options_.topology);
  std::string points = hal::default_point_map(built_in.counts.vavs, built_in.counts.fcus, built_in.counts.powers,
                                              options_.stand_ins, options_.band) +
                       options_.more_points;
  if (!options_.setpoint_point.empty()) {
    const std::size_t row = points.find("\nsetpoint,") + 1;
    points.replace(row, points.find('\n', row) - row, options_.setpoint_point);
  }
  write_text(folder_ / "points.csv", points);
  if (!options_.stand_ins.empty()) options_.more_site += "[stand_in]\n";
  for (const auto& [name, value] : options_.stand_ins.by_name()) {
    options_.more_site += fmt::format("{} = {}\n", name, value);
  }
  write_site(options_.serial ? fmt::format("transport = \"rtu\"\ndevice = \"{}\"\nbaud = 115200\nparity = \"N\"\n",
                                           (folder_ / "line").string())
                             : "transport = \"tcp\"\nhost = \"127.0.0.1\"\nport = 502\n");
  trial_.site = tools::load_site((folder_ / "site.toml").string());
  trial_.plant = options_.plant;
  trial_.expert_days = options_.expert_days;
  trial_.days = options_.days;
  if (!options_.band) {
    blob_ = weights_for(trial_.site);
    hal::write_blob_file((folder_ / "weights.blob").string(), blob_);
  }
  prepared_ = tools::prepare(trial_);
  hal::LogWriter history((folder_ / "history.csv").string(), trial_.site.counts, true);
  for (const hal::LogRow& row : prepared_.history) history.append(row);
  history.close();
}

Bench::~Bench() {
  server_.reset();
  if (::testing::Test::HasFailure()) return;  // what is left shows why
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void Bench::write_site(const std::string& transport) const {
  std::string parts = options_.expert_days > 0 ? "[history]\nlog = \"history.csv\"\n" : "";
  parts += options_.band ? "[setpoint]\nmin_degc = 12.0\nmax_degc = 18.0\n[expert]\nwork_degc = 14.0\noff_degc = 14.0\n"
                         : "[weights]\nblob = \"weights.blob\"\n";
  write_text(
      folder_ / "site.toml",
      fmt::format("[site]\nname = \"Bench\"\ntopology = \"{}\"\nscope = \"Bench\"\n"
                  "[controller]\nseed = {}\ncycle_min = {}\n{}[modbus]\n{}unit_id = 1\ndeadline_s = 10.0\npoints = "
                  "\"points.csv\"\n"
                  "[clock]\nsource = \"plant\"\n[state]\ndir = \"state\"\n[log]\ndir = \"log\"\nmax_files = 400\n"
                  "{}{}",
                  options_.topology, options_.plant.seed, options_.cycle_min,
                  options_.band ? "objective = \"band\"\n" : "", transport, parts, options_.more_site));
}

std::filesystem::path Bench::program(const std::string& name) const {
  const char* daemon = std::getenv("AIRSIDE_DAEMON");
  if (name == "airsided" && daemon != nullptr && *daemon != '\0') return daemon;
  return fs::path(AIRSIDE_BIN_DIR) / name;
}

const LogText& Bench::expected() {
  if (expected_.rows.empty()) {
    run_ = tools::run_controller(trial_.site, *prepared_.model, blob_, prepared_.history, prepared_.until,
                                 trial_.site.file.seed);
    expected_ = text_of_rows(trial_.site, run_.rows);
  }
  return expected_;
}

void Bench::start_server() {
  const fs::path ready = folder_ / "ready";
  fs::remove(ready);
  const tools::PlantChoice& plant = options_.plant;
  std::vector<std::string> command = {program("airside"), "serve",
                                      "--site",           folder_ / "site.toml",
                                      "--plant",          plant.kind,
                                      "--room",           plant.room,
                                      "--start",          plant.start,
                                      "--seed",           std::to_string(plant.seed),
                                      "--expert-days",    std::to_string(options_.expert_days),
                                      "--days",           std::to_string(options_.days),
                                      "--ready",          ready};
  if (options_.serial) {
    command.insert(command.end(), {"--pty", folder_ / "line"});
  } else {
    command.insert(command.end(), {"--port", "0"});
  }
  server_ = std::make_unique<Child>(command, folder_ / "server.txt");
  const double deadline_s = now_s() + 300;
  while (lines_of(ready).empty()) {
    if (!server_->running() || now_s() > deadline_s) throw std::runtime_error("airside serve: " + server_->said());
    sleep_s(0.01);
  }
  if (options_.serial) return;
  const std::string where = lines_of(ready).front();
  write_site(fmt::format("transport = \"tcp\"\nhost = \"127.0.0.1\"\nport = {}\n", where.substr(where.rfind(':') + 1)));
}

std::unique_ptr<Child> Bench::start_daemon(bool sync, const std::vector<std::string>& more) {
  const CivilTime end{tools::start_of(options_.plant).seconds + (options_.expert_days + options_.days) * 86400LL};
  std::vector<std::string> command = {program("airsided"), "--site", folder_ / "site.toml", "--backoff", "0.05"};
  const auto unless_said = [&](const std::string& option, const std::string& value) {
    if (std::ranges::find(more, option) == more.end()) command.insert(command.end(), {option, value});
  };
  unless_said("--until", hal::civil_text(end));
  unless_said("--crash-limit", "0");  // tests that kill it start it more often than any crash loop
  if (!sync) command.emplace_back("--no-sync");
  command.insert(command.end(), more.begin(), more.end());
  return std::make_unique<Child>(command, folder_ / "daemon.txt");
}

LogText Bench::log() const {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder_ / "log")) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  LogText text;
  for (const fs::path& path : files) {
    const auto lines = lines_of(path);
    if (lines.empty()) continue;
    text.header = lines.front();
    text.rows.insert(text.rows.end(), lines.begin() + 1, lines.end());
  }
  return text;
}

nlohmann::json Bench::status() const {
  nlohmann::json status;
  for (int look = 0; look < 1000; ++look) {
    std::ifstream in(folder_ / "state" / "status.json");
    status = nlohmann::json::parse(in, nullptr, false);
    if (status.is_object()) break;
    sleep_s(0.01);
  }
  return status;
}

std::size_t Bench::logged_rows() const {
  std::size_t files = 0;
  fs::path newest;
  for (const auto& entry : fs::directory_iterator(folder_ / "log")) {
    if (entry.path().extension() != ".csv") continue;
    ++files;
    newest = std::max(newest, entry.path());
  }
  if (files == 0) return 0;
  std::ifstream in(newest, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  return (files - 1) * rows_per_day + (lines > 0 ? lines - 1 : 0);
}

namespace {

/// A field of a row whose fraction has more digits than a person would write; "" where there is none. Losses have all
/// their digits: by them rows are the same to the bit.
std::string long_field(const std::string& header, const std::string& row) {
  std::vector<bool> is_loss(1);
  for (std::size_t at = 0; at < header.size(); ++at) {
    if (header[at] == ',') is_loss.push_back(header.compare(at + 1, 5, "loss_") == 0);
  }
  std::size_t column = 0;
  for (std::size_t at = 0; at < row.size(); ++column) {
    const std::size_t end = std::min(row.find(',', at), row.size());
    const std::string field = row.substr(at, end - at);
    const std::size_t point = field.find('.');
    const bool is_small = field.starts_with("0.000") || field.starts_with("-0.000") || field.find('e') != field.npos;
    if (point != field.npos && !is_small && !is_loss.at(column) && field.size() - point - 1 > 6) return field;
    at = end + 1;
  }
  return "";
}

}  // namespace

void expect_same_rows(const LogText& log, const LogText& expected) {
  EXPECT_EQ(log.header, expected.header);
  EXPECT_EQ(log.rows.size(), expected.rows.size());
  const std::size_t n = std::min(log.rows.size(), expected.rows.size());
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_EQ(log.rows[i], expected.rows[i]) << "row " << i << " of " << n;
    ASSERT_EQ(long_field(log.header, log.rows[i]), "") << "row " << i << ": " << log.rows[i];
  }
}

}  // namespace airside::closed_loop
