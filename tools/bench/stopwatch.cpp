#include "tools/bench/stopwatch.hpp"

#include <sys/resource.h>

#include <cstdio>

namespace airside::tools {

double Stopwatch::now_us() const {
  timespec t{};
  clock_gettime(clock_, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

void Stopwatch::print(const Measured& what, std::vector<double>& us) {
  std::sort(us.begin(), us.end());
  const double median = us[us.size() / 2];
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "{\"name\":\"%s\",\"batch\":%d,\"threads\":1,\"median_us\":%.2f,\"min_us\":%.2f,\"max_us\":%.2f,\"p90_us\":%.2f,"
      "\"runs\":%zu,\"rss_mb\":%.1f",
      what.name.c_str(), what.batch, median, us.front(), us.back(), us[us.size() * 9 / 10], us.size(),
      static_cast<double>(usage.ru_maxrss) / 1024.0);
  if (what.shape.valid())
    std::printf(",\"shape\":\"%s\",\"topology\":\"%s\"", name_of(what.shape).c_str(), what.topology);
  if (what.flops > 0) {
    std::printf(",\"median_gflops\":%.1f,\"best_gflops\":%.1f", what.flops / median / 1e3,
                what.flops / us.front() / 1e3);
  }
  std::printf("}\n");
  std::fflush(stdout);
}

}  // namespace airside::tools
