// libFuzzer's hooks for the one target that AIRSIDE_FUZZ_TARGET names.
//   fuzz_NAME --seeds DIR   writes the seeds to DIR and the dictionary to DIR.dict, and ends

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "fuzz/target.hpp"

using airside::fuzz::Bytes;
static const airside::fuzz::Target& target = airside::fuzz::AIRSIDE_FUZZ_TARGET;

// Names and types are libFuzzer's.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t max_size);
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size,
                                               unsigned seed);

static void write_seeds(const std::string& dir) {
  std::filesystem::create_directories(dir);
  int number = 0;
  for (const Bytes& seed : target.seeds()) {
    std::ofstream out(dir + "/seed-" + std::to_string(number++), std::ios::binary);
    out.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
  }
  std::ofstream dictionary(dir + ".dict");
  if (target.words == nullptr) return;
  for (const std::string& word : target.words()) {
    dictionary << '"';
    for (const char c : word) {
      if (c == '"' || c == '\\') dictionary << '\\';
      dictionary << c;
    }
    dictionary << "\"\n";
  }
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (int i = 1; i + 1 < *argc; ++i) {
    if (std::strcmp((*argv)[i], "--seeds") != 0) continue;
    write_seeds((*argv)[i + 1]);
    std::printf("max_len %zu\n", target.max_bytes);
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  target.run({bytes, size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  size = LLVMFuzzerMutate(bytes, size, max_size);
  if (target.repair == nullptr || seed % 8 == 0) return size;
  Bytes input(bytes, bytes + size);
  target.repair(input, seed / 8);
  size = input.size() < max_size ? input.size() : max_size;
  std::copy_n(input.begin(), size, bytes);
  return size;
}
