// Reads a weight blob, shows the controller one reading, and prints the setpoint that it decides on.

#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "airside/controller/instances.hpp"
#include "airside/controller/weight_payload.hpp"
#include "airside/presets.hpp"

using namespace airside;

int main(int argc, char** argv) {
  std::ifstream file(argc == 2 ? argv[1] : "", std::ios::binary);
  const std::string blob{std::istreambuf_iterator<char>(file), {}};
  auto payload = std::make_unique<WeightBlob<FiveZone>::Payload>();
  const auto header = WeightBlob<FiveZone>::decode(std::as_bytes(std::span(blob)), {}, *payload);
  if (!header) {
    std::fprintf(stderr, "blob refused: %s, %s\n", text_of(header.error().fault), header.error().field);
    return 1;
  }
  auto controller = std::make_unique<Controller<FiveZone, float>>();
  controller->configure(product_settings(), default_limits<FiveZone>(), select_kernels<float>(), 1);
  take_payload<FiveZone>(*controller, *payload);

  Reading<FiveZone> reading{.time = {1628553600 + 10 * 3600}};  // 2021-08-10, a Tuesday, 10:00
  for (int i = 0; i < Layout<FiveZone>::signals; ++i)
    reading.value(i) = is_status(signal_id<FiveZone>(i).kind) ? 1 : 23.5;
  reading.setpoint_degc = 21;
  const Decision& decision = controller->decide(reading.time, reading);
  std::printf("%.2f degC, control mode %s\n", decision.command.setpoint_degc(), text_of(decision.mode));
}
