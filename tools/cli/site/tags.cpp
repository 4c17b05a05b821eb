// airside tags: a site in the words of building software, Brick or Project Haystack.

#include <fmt/format.h>

#include <string>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/tags/brick.hpp"
#include "tools/tags/haystack.hpp"
#include "tools/tags/site_points.hpp"

namespace airside::tools {

namespace {

struct TagsCommand {
  std::string site, format = "brick", output;
  bool json = false;

  void run() const {
    if (json && output.empty()) {
      throw hal::InputError("--json", "no -o beside it", "a file for the tags, since standard output has the summary",
                            "add -o FILE, or leave --json out");
    }
    const Site read = load_site(site);
    const std::string text = format == "brick" ? brick_model(read) : haystack_grid(read).dump(1) + "\n";
    if (output.empty()) {
      fmt::print("{}", text);
      return;
    }
    hal::StagedFile file(output);
    file.write(text);
    file.commit();
    const std::size_t points = site_points(read).size();
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"file", output}, {"format", format}, {"points", points}}.dump());
    } else {
      fmt::print("wrote {}: {} points of \"{}\"\n", output, points, read.file.name);
    }
  }
};

}  // namespace

void add_tags(CLI::App& app) {
  auto self = std::make_shared<TagsCommand>();
  CLI::App* c = app.add_subcommand(
      "tags",
      "describe a site's AHU, boxes, zones, fan coils, meters and points in the words of building software:\n"
      "brick: Turtle for Brick 1.3 and 1.4 with QUDT units; haystack: a grid of Project Haystack 4 as JSON.\n"
      "Each point carries its column of the log and, where the site has [modbus], its register, or its BACnet object.");
  c->add_option("site", self->site, "site file")->required();
  c->add_option("--format", self->format, "brick or haystack")
      ->check(CLI::IsMember({"brick", "haystack"}))
      ->capture_default_str();
  c->add_option("-o,--output", self->output, "where to write (default: standard output)");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output; needs -o");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
