// The host's half of the comparison: the same day, printed the same way; and the blob that both start from.

#include <charconv>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "airside/presets.hpp"
#include "firmware/cortex_m/day.hpp"

namespace airside::cortex_m {
namespace {

constexpr const char* usage =
    "usage: cortex-m-day sound|faulty BLOB     the day on standard output\n"
    "       cortex-m-day make-blob DAYS BLOB   trains on DAYS other days and writes the weights\n";

void print(std::string_view line) { std::fwrite(line.data(), 1, line.size(), stdout); }

struct NoLog {
  bool row(CivilTime, const Expected<Reading<Topo>>&, const Box&) { return true; }
};

/// Seeded weights, a scaler from a day under the schedule, then `days` of control with learning.
int make_blob(int days, const char* path) {
  auto box = std::make_unique<Box>();
  box->configure(product_settings(), default_limits<Topo>(), strict_kernels<float>(), 5);
  RoomModel room(schedule_day, 77);
  SplitMix64 draw(42);
  box->draw_weights(draw);
  ScalerFit<Topo> fit;
  live_by_schedule(room, box->settings(), schedule_day, [&](CivilTime, const auto& value, double) { fit.add(value); });
  box->start(fit.fit(box->settings()));
  NoLog log;
  run_cycles<Topo>(room, room, *box, log, scored_day, CivilTime{scored_day.seconds + days * std::int64_t{86400}});

  auto payload = std::make_unique<Payload>();
  give_payload<Topo>(*box, *payload);
  std::snprintf(payload->provenance.data(), payload->provenance.size(), "{\"plant\":\"firmware/cortex_m\",\"days\":%d}",
                days);
  std::vector<std::byte> bytes(WeightBlob<Topo>::max_bytes);
  BlobHeader header;
  header.created_s = scored_day.seconds;
  bytes.resize(WeightBlob<Topo>::encode(header, *payload, bytes));
  std::ofstream out(path, std::ios::binary);
  for (const std::byte b : bytes) out.put(static_cast<char>(b));
  if (!out.flush()) {
    std::fprintf(stderr, "cortex-m-day: cannot write %s\n", path);
    return 1;
  }
  std::printf("%s: %zu bytes after %d days\n", path, bytes.size(), days);
  return 0;
}

int run(Scenario scenario, const char* path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    std::fprintf(stderr, "cortex-m-day: cannot read %s; write it with cortex-m-day make-blob 3 %s\n", path, path);
    return 1;
  }
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  auto box = std::make_unique<Box>();
  auto payload = std::make_unique<Payload>();
  box->configure(product_settings(), default_limits<Topo>(), strict_kernels<float>(), 9);
  RoomModel room(schedule_day, 2021);
  LineWriter out(print);
  const auto blob = std::as_bytes(std::span(text.data(), text.size()));
  return run_day(*box, *payload, blob, room, room, room, scenario, out) ? 0 : 1;
}

}  // namespace
}  // namespace airside::cortex_m

int main(int argc, char** argv) {
  using namespace airside::cortex_m;
  const std::string job = argc > 1 ? argv[1] : "";
  if (job == "sound" && argc == 3) return run(Scenario::sound, argv[2]);
  if (job == "faulty" && argc == 3) return run(Scenario::faulty, argv[2]);
  if (job == "make-blob" && argc == 4) {
    int days = 0;
    const std::string_view text = argv[2];
    const auto [end, error] = std::from_chars(text.begin(), text.end(), days);
    if (error == std::errc() && end == text.end() && days > 0 && days < 1000) return make_blob(days, argv[3]);
  }
  std::fputs(usage, job == "--help" ? stdout : stderr);
  return job == "--help" ? 0 : 2;
}
