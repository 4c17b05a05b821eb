// airside-energyplus RUN.JSON: one EnergyPlus run for a parent that holds the other end of socket 3.

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "sim/energyplus/worker/worker.hpp"

namespace {

void report(const std::string& text) {
  airside::sim::WorkerReply reply;
  reply.kind = airside::sim::ReplyKind::error;
  std::copy_n(text.data(), std::min(text.size(), reply.text.size() - 1), reply.text.data());
  send(airside::sim::worker_socket, &reply, sizeof reply, MSG_NOSIGNAL);
}

}  // namespace

int main(int argc, char* argv[]) {
  if (argc != 2) {
    std::fputs("usage: airside-energyplus RUN.JSON\nA part of airside that the other programs start.\n", stderr);
    return 2;
  }
  try {
    const auto config = airside::sim::read_run_config(argv[1]);
    const auto api = airside::sim::open_engine(config.engine_library);
    airside::sim::Worker worker(config, api, airside::sim::worker_socket);
    const int result = worker.run();
    // The engine's own clean-up frees nothing that the process's end does not.
    std::fflush(nullptr);
    _exit(result);
  } catch (const std::exception& error) {
    report(error.what());
    return 1;
  }
}
