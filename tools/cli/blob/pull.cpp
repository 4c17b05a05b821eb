// airside pull: the weights that a box has learned, from its page or from its state folder.

#include <fmt/format.h>

#include <filesystem>

#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "hal/weights/blob_file.hpp"
#include "tools/cli/blob/blob_facts.hpp"
#include "tools/cli/blob/http_box.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_blob_bytes = 4u << 20;

/// The file in a state folder, given itself, as the folder or by a site file.
std::string given_file(const std::string& source) {
  fs::path path(source);
  if (path.extension() == ".toml") path = hal::read_site_file(source, hal::site_rules()).state_dir;
  std::error_code error;
  if (fs::is_directory(path, error)) path /= "weights.blob";
  if (fs::exists(path, error)) return path.string();
  throw hal::InputError(path.string(), error ? error.message() : "no such file",
                        "the weights that airsided gives out once a day",
                        "give a box's address (http://HOST:PORT), its state folder, or its site file");
}

struct PullCommand {
  std::string source, out;
  BoxAccess access;
  bool json = false;

  void run() const {
    const bool web = is_web_address(source);
    const std::string from = web ? source : given_file(source);
    const std::vector<std::byte> bytes =
        web ? HttpBox(source, access).get("/weights.blob", longest_blob_bytes) : hal::read_blob_file(from);
    const BlobFacts facts = facts_of_blob(bytes, from);
    if (facts.refusal) throw *facts.refusal;
    hal::write_blob_file(out, bytes);
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"from", from},
                                        {"blob", out},
                                        {"bytes", bytes.size()},
                                        {"topology", facts.topology},
                                        {"key_id", key_text(facts.header)},
                                        {"provenance", facts.provenance}}
                             .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
      return;
    }
    fmt::print("wrote {} ({} bytes): {}\n", out, bytes.size(),
               facts.provenance.empty() ? "it says nothing of where it was learned" : facts.provenance);
    fmt::print("For another room: airside sign {} --key YOUR.key, then airside push.\n", hal::shell_word(out));
  }
};

}  // namespace

void add_pull(CLI::App& app) {
  auto self = std::make_shared<PullCommand>();
  CLI::App* c =
      app.add_subcommand("pull", "fetch the weights that a box has learned, to look into or to sign for others");
  c->add_option("source", self->source,
                "http://HOST:PORT or https://HOST:PORT of airside-page, a state folder, or a site file")
      ->required();
  c->add_option("-o,--out", self->out, "blob to write")->required();
  c->add_option("--ca", self->access.ca, "PEM file of the certificates to trust, such as the box's own");
  c->add_option("--access", self->access.key_file,
                "file with a key of the box's page, where viewers need one (airside-page --new-key viewer)");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

nlohmann::json send_over_http(const std::string& address, std::span<const std::byte> blob, const BoxAccess& access) {
  const std::string said = HttpBox(address, access).send_blob(blob);
  return {{"bytes", blob.size()}, {"address", address}, {"said", said}};
}

}  // namespace airside::tools
